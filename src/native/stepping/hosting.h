// People in another engine's world (docs/physics.md, "In another program's MuJoCo world"): the host
// moves all bodies but people; from the velocity that it gives them the impulses between them and
// people are solved as everywhere else.
//
//   begin    where people are driven in a frame of n timesteps, and whether they meet anything on
//            their way: who does not needs no substeps (free_paths.h)
//   before   a timestep of the host: the weight of who stands on movable things is among its forces
//   after    it: the host's velocities are those without people, a substep makes those with them, and
//            bodies that were touched get theirs. While nobody meets anything it is enough that the
//            host's bodies went no farther than was assumed; if they did, people are stepped through
//            from there on.
//   end      people whom nothing touched have arrived; the forces of the last timestep, weights too,
//            stay among the host's until the next one, for whoever reads them
#pragma once
#include "stepping/aiming.h"
#include "stepping/free_paths.h"
#include "stepping/host.h"
#include "stepping/substep.h"

namespace hp {

class Hosting {
 public:
  // A frame towards the people's `targets` begins: n timesteps of length h [s]. With `watched` people
  // are shown before every timestep, else before the last one.
  void begin(System& system, Data& data, Aiming& aiming, Host& host, const double* targets, int n,
             double h, bool watched);
  void before(System& system, Data& data, int k);
  void after(System& system, Data& data, Substep& substep, int k);
  void end(System& system, Data& data);
  // After a reset: no force is ours, and people are shown.
  void start(System& system, Data& data, Host& host);
  static void show(System& system, Data& data, Host& host);
  const AppliedForces& forces() const { return forces_; }
  AppliedForces& forces() { return forces_; }

 private:
  // How the host's pose differs from the one that the last substep ended in.
  enum class Change { None, Rounding, Placed };
  Change take_pose(const System& system, State& state) const;
  void take(System& system, State& state);
  void show_path(const System& system, double share);
  void pose_bodies(const System& system, const State& state);
  void press(const System& system, const State& state);
  bool stay_clear(System& system, const State& state);
  void leave_paths(System& system, Data& data, int k);
  void move_all(System& system, Data& data);
  void make_substep(System& system, Data& data, Substep& substep, int k);
  void give_back(const System& system, const Data& data);

  Host* host_ = nullptr;
  int n_ = 1;
  double h_ = 0;
  bool watched_ = false;
  bool free_ = false;  // nobody has met anything in this frame
  FreePaths paths_;
  AppliedForces forces_;
  std::vector<StandingLoad::Pressing> pressing_;
  std::vector<double> qpos_, qvel_;    // the host's, before a timestep
  std::vector<double> v_free_, path_;  // per dof; per coordinate
  std::vector<double> way_, inner_;    // per shape [m]
  std::vector<char> hosted_;           // per body: it is the host's
  Poses now_;
};

}  // namespace hp
