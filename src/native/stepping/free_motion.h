// The velocity v* that a substep of length h would end with without contact.
//
//   people          Drive::free_velocity (docs/physics.md, "The drive"); with forces of their own
//                   v* += M^^-1 (X deviation / h + impulses)
//   articulations   (M + h D + h^2 K)(v* - v) = h (springs - damping - c), dynamics/articulation.h
//   objects         v* = v + h g; rotation by the implicit midpoint rule, Newton on
//                   2 I (w - w0) + h w x I w = 0 for the velocity w of mid-substep [rad/s]
//
// Objects move by w; `Step::spin` is what is then missing to the velocity at the end of the
// substep.
#pragma once
#include <vector>

#include "stepping/baselines/internal_forces.h"
#include "stepping/data.h"

namespace hp {

class FreeMotion {
 public:
  // v* of people (before limits of strength) and articulations in substep k of the frame, into
  // step.v_free.
  void drive(System& system, Data& data, InternalForces& internal, int k, double h);

 private:
  std::vector<double> impulse_;  // per dof, then the change of velocity that it makes
};

// v* and spin of objects; with `only` (per body) of those.
void object_velocity(const System& system, const State& state, Step& step, double h,
                     const std::vector<char>* only = nullptr);

}  // namespace hp
