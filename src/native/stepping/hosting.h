// People in another engine's world (docs/physics.md, "In another program's MuJoCo world"): the host
// moves all bodies but people and says, substep by substep, where they are and which velocity they
// would have without the people. The impulses between the two are solved as everywhere else.
#pragma once
#include "stepping/aiming.h"
#include "stepping/substep.h"

namespace hp {

class Hosting {
 public:
  // A frame of length dt [s] towards the people's `targets` begins.
  void begin(System& system, Data& data, Aiming& aiming, const double* targets, double dt);
  // Substep k of length h [s] from `qpos`, `qvel` (people's entries are not read). `v_free`: the
  // other bodies' velocity at its end without people; `damping`: of their joints, implicit, per
  // dof.
  void substep(System& system, Data& data, Substep& substep, int k, double h, const double* qpos,
               const double* qvel, const double* v_free, const double* damping);
  void end(System& system, Data& data);

 private:
  // How the host's pose differs from the one that the last substep ended in.
  enum class Change { None, Rounding, Placed };
  Change take_pose(const System& system, State& state, const double* qpos) const;

  std::vector<char> settled_;       // per person: it was where the motion has it
  std::vector<double> start_qpos_;  // of the frame
};

}  // namespace hp
