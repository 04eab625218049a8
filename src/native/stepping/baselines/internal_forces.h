// Baseline: internal forces and joint damping of people, which the paper leaves out
// (docs/physics.md, "Forces that half-physics leaves out, and torques"). With v0 what v* would be
// without them:
//
//   (M^ + h D) (v* - v0) = -h c(q, v) - h D v0,     M^ + h D in place of M^
//
// c are the Coriolis, centrifugal and gyroscopic forces of a person's tree at the start of the
// substep, D [N m s/rad] acts with the velocity at its end. Free motion is not exact with them, so
// every person is stepped through.
#pragma once
#include <vector>

#include "stepping/system.h"

namespace hp {

struct State;
struct Step;

class InternalForces {
 public:
  // Adds the impulses -h c - h D v0, per dof, to `impulse`; v0 is step.v_free.
  void add_impulses(const System& system, const State& state, const Step& step, double h,
                    std::vector<double>& impulse);
  // Limits the change of velocity `change` = v* - v0 so that no joint turns faster than
  // kFastestInternalSpin, or than it did.
  void limit(const System& system, const Step& step, std::vector<double>& change) const;
  // Takes the impulses of these forces, in a substep that ended with the velocities `v`, off
  // `impulse`.
  void discount(const System& system, const Drive& d, const double* v, double h,
                double* impulse) const;

 private:
  std::vector<double> impulse_;  // -h c, per dof
};

}  // namespace hp
