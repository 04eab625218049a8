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

  // How much of the balance is that of somebody who rests: 0 while the root moves, 1 once it is still.
  double rest() const { return carry_ ? rest_ : 0; }
  // What stands on hard ground beside them: feet, and nothing else.
  struct Feet {
    bool on = false;
    Vec3 centre;         // of their soles [m]
    double breadth = 0;  // half of what they span, seen from the centre of mass [m]
    double legs = 0;     // share of the weight that hangs on them, if legs do nothing
  };
  const Feet& feet() const { return feet_; }

  // A frame begins with what else could carry it, a person whose centre of mass is over `centre`: of these points
  // the first `soles` are feet's, and `legs` is the share of the weight that rests on them of legs that do nothing.
  // `sits`: skin but the feet's is at rest on something.
  void aim(const std::vector<BearingPoint>& others, size_t soles, double legs, Vec3 centre,
           bool sits);
  // The frame, of length dt [s], moves the root at `speed` [m/s]; only who sits or lies rests.
  void move(double speed, bool sits, double dt);
  // Of who rests feet are to carry this share of the weight.
  void feet_carry(double share) { feet_share_ = share; }
  // Time `h` [s] passes.
  void advance(double h);
  // In a frame of length dt [s] layers have pressed with so much of the person's weight, at `centre`.
  void pressed(double weights, Vec3 centre, double dt);

  void reset();
  void save(std::vector<double>& out) const;
  const double* restore(const double* in);

 private:
  static Feet find_feet(const std::vector<BearingPoint>& points, size_t soles, double legs,
                        Vec3 centre);

  bool carry_ = false;
  bool stands_ =
      false;  // what is hard carries it too, and it does not sit: a touch of a layer is none that carries
  double share_ = 0, target_ = 0;  // of the weight
  double pressed_ = 0;             // what they carry, in the person's weight, smoothed
  Vec3 centre_;                    // of their pressure, smoothed [m]
  double rest_ = 0, feet_share_ = 0;
  Feet feet_;
};

}  // namespace hp
