// On layers: how much of a person's weight soft layers are to carry.
//
// What stands on hard ground is put there by footing, and needs no force. On a soft layer a person sinks until
// the pressures carry what nothing else does: while layers press on it, its height is no more that of a
// target, but falls with gravity and is held by contacts (stepping/layer_load.h). The share w of the weight that
// they are to carry is found as bearing.h finds shares, with one more point, the centre of the layers' pressure, beside
// those that rest on hard ground:
//
//   spread over {feet on the floor, hard seat, ...} and the centre x_L  ->  w = s_L
//
// so that all moments about the ground point under the centre of mass balance: the law of the lever. Where that
// leaves a choice (soles are long) layers keep what they have, and have half of it at least under somebody who sits
// or lies on them. w = 1 where nothing else carries. Who leans forward to stand up has its centre of mass over its feet: then w is 0, the seat
// pushes it up to its surface, and footing has it again.
#pragma once
#include <vector>

#include "footing/bearing.h"

namespace hp {

class OnLayers {
 public:
  // Do layers carry the person in this frame?
  bool carry() const { return carry_; }
  // The share of the weight that they are to carry now; 0 if they do not.
  double share() const { return carry_ ? share_ : 0; }

  // A frame begins with what else could carry it, a person whose centre of mass is over `centre`; `sits`: skin
  // but the feet's is at rest on something.
  void aim(const std::vector<BearingPoint>& others, Vec3 centre, bool sits);
  // Time `h` [s] passes.
  void advance(double h);
  // In a frame of length dt [s] layers have pressed with so much of the person's weight, at `centre`.
  void pressed(double weights, Vec3 centre, double dt);

  void reset();
  void save(std::vector<double>& out) const;
  const double* restore(const double* in);

 private:
  bool carry_ = false;
  double share_ = 0, target_ = 0;  // of the weight
  double pressed_ = 0;             // what they carry, in the person's weight, smoothed
  Vec3 centre_;                    // of their pressure, smoothed [m]
};

}  // namespace hp
