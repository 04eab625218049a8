// Wading: how the feet of somebody on soft layers leave the layers and come down on them.
//
// A foot that carries sinks into a layer, so that the whole person is lower than where the motion has it, and a foot
// that swings would go through what it is to step on. Each foot has a share w_f of the weight, by the law of the
// lever (bearing.h) between the feet that rest (where none does, between those that are low), whatever they rest on, about the point where the centre of mass will
// be in kWadeAhead: weight is taken over before the other foot leaves. With s how far a sole would be below the
// surface of its layer if the leg were as the motion has it, the leg lifts it by
//
//   u_f = s (1 - w_f / m) + (1 - r_f) c_f,   m = W + q (1 - W),   W = max w
//
// r_f: whether it rests, c_f: how high the motion has its sole above the lowest point of the person. So a foot that
// swings is as high over the surface as over the ground of the motion, and while one foot takes the weight over from
// the other they go down and up together, so that the depths of both sum to that of one and the person keeps its
// height. q is 1 while one foot rests and another does not; it fades while all or none do, and then m = W: the foot
// that carries most has the leg of the motion. Shares follow what is wanted like a critically damped spring.
//
// What pushes a wader up is the ground, and holds nobody back: hindered is who is pushed along it by something else.
#pragma once
#include <vector>

#include "footing/bearing.h"
#include "footing/footing_model.h"
#include "footing/footwork.h"
#include "footing/stance.h"
#include "footing/underfoot.h"

namespace hp {

class Wading {
 public:
  // A frame of length dt [s] of a stance over `under`, whose centre of mass is `centre` seen from the reference [m].
  void frame(const FootingModel& model, const Stance& stance, const Footwork& work,
             const Underfoot& under, Vec3 centre, double dt);
  // By how much the leg of a foot is to lift it whose sole would be `sunk` below the surface of its layer [m].
  // The person rises at a speed off its motion [m/s].
  double lift(const Stance& stance, size_t leg, double sunk, double rises) const;
  // How much higher the person would have to be than the reference for the foot that is to carry most to stand on
  // the frame of what it is in, its leg as the motion has it [m]; -1e300: there is none.
  double least() const { return least_; }

  // In a frame of length dt [s] something pushed the person along the ground, or nothing did.
  void pushed(bool aside, double dt);
  bool hindered() const { return hindered_ > 0; }

  // Nothing soft is under the person.
  void leave();
  void clear(size_t legs);
  void save(std::vector<double>& out) const;
  const double* load(const double* in);

 private:
  void find_least(const Underfoot& under);

  struct Foot {
    double share = 0, rate = 0;  // w_f, and its speed [1/s]
  };
  std::vector<Foot> feet_;
  double walks_ = 0;    // q
  bool known_ = false;  // shares and centre are of the frame before
  double least_ = -1e300;
  Vec3 centre_;          // of mass [m]
  double hindered_ = 0;  // for how long it still counts as pushed [s]
};

}  // namespace hp
