// Kinematic bodies: objects that follow a trajectory (docs/physics.md, "Kinematic bodies and
// sleeping objects").
//
// In every substep a kinematic body has the velocity that takes it from where it is to where its
// trajectory has it after the substep. To contacts it has infinite mass: its velocity enters v_n,
// and no impulse changes it (Model::held). A shortened step shortens its own: its clock goes on
// where it was stopped, and lost time is not made up.
//
// Crushing. Where a kinematic body leaves others no room, contacts ask for impulses without end
// (SolveReport::crushed). It then goes at a quarter of its pace in that substep, at a sixteenth,
// and then stands, and everything else makes the whole substep. It doubles its pace in every
// substep after that; when it stands it tries again after 1, 2, 4 to 32 substeps. Meanwhile its
// island gets no clearance back, which would take room on both sides, and friction does not hold
// people there: where everything is wedged it has no answer, or many.
#pragma once
#include <vector>

#include "stepping/data.h"

namespace hp {

// Poses of a kinematic body: straight lines, and turns at a constant rate, between them.
struct Trajectory {
  int body = 0;
  double fps = 30;    // poses per second
  bool loop = false;  // the first pose follows the last one
  std::vector<Vec3> position;
  std::vector<Quat> turn;

  // The pose at `time` [s] since the first one.
  void at(double time, Vec3& p, Quat& q) const;
};

class KinematicBodies {
 public:
  // Throws std::invalid_argument unless the body is an object and there are as many turns as
  // positions.
  void add(const Model& m, Trajectory trajectory);
  void finish(Model& m);  // after model.finish()
  void reset(const Model& m);

  // A substep begins: bodies that were slowed down gain speed again; those that stand try now and
  // then.
  void gain_pace();
  // Their velocities in a substep of length h, into step.v_free.
  void set_velocity(const Model& m, const State& state, Step& step, double h) const;
  // After an attempt that failed: bodies that leave others no room go slower, or stand. True if
  // there are any.
  bool slow_down(const System& system, Data& data);
  // Islands with a body that was slowed down get no clearance back: sets attempt.relaxed.
  void give_up_clearance(const System& system, Data& data) const;
  // Friction does not hold people there either.
  void drop_friction(const System& system, Data& data) const;
  // Mass of all active bodies of an island that contacts can push [kg]; 0 without kinematic bodies.
  double pushable_mass(const System& system, const Islands& islands, int island) const;

  // A tree has made all but `late` [s] of the substep under way.
  void set_late(int body, double late) { late_[body] = late; }
  // A substep of length h has ended: clocks go on. Returns the most time that a body has lost [s].
  double pass_time(const Model& m, double h);

  void save(std::vector<double>& out) const;
  const double* load(const double* in);
  // `body`: the number of each body in `old`, -1: it is new.
  void adopt(const KinematicBodies& old, const std::vector<int>& body);

 private:
  // How fast a body goes on, as a share of what its trajectory asks; and when it stands, how many
  // substeps it waits before it tries again, and waits after that.
  struct Pace {
    double share = 1;
    int wait = 0, patience = 0;
  };
  // Per island: a body in it was slowed down.
  std::vector<char> slowed(const System& system, const Data& data) const;

  std::vector<Trajectory> trajectories_;
  std::vector<double> clock_;  // per trajectory: where on it the body is [s]
  std::vector<Pace> pace_;     // per trajectory
  std::vector<double> late_;   // per body: time lost in the substep under way [s]
};

}  // namespace hp
