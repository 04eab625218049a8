// One attempt at a step of length h from the present pose: velocities with contact, and the pose
// that they end in, verified. This is the inner part of the substep (docs/physics.md, "The
// substep", 2 to 7):
//
//   repeat, with a larger reach where a contact sped a body up beyond it (7):
//     broad phase       pairs of shapes within reach of where v* would take them (2)
//     candidates        separating planes of those pairs, with the gap that each demands
//     verify            v = v*: move, check every candidate at the end pose (3)
//     repeat until no candidate is violated, island by island (islands.h):
//       contacts        points of violated candidates, warm start, better predictions (4)
//       solve           impulses p: M^ (v - v*) = J^T p, Coulomb (contact/solver.h) (5)
//       verify          move, check again
//       relax           where that does not converge, the clearance of the island gives way (6)
//     rebounds          a second solve where restitution asks for one
//
// The answer is in data.step (v, end, end_qpos) and data.attempt (good, worst, contacts).
#pragma once
#include "collision/friction_places.h"
#include "stepping/island_response.h"
#include "stepping/joint_ranges.h"
#include "stepping/kinematic_bodies.h"
#include "stepping/path_curvature.h"
#include "stepping/restitution.h"
#include "stepping/standing_friction.h"
#include "stepping/verification.h"

namespace hp {

class ContactStep {
 public:
  ContactStep(System& system, Data& data, const KinematicBodies& kinematic)
      : system_(system), data_(data), kinematic_(kinematic) {}
  void run(double h);

 private:
  void begin(double h);
  void estimate_reach(double h);
  void find_candidates(double h);
  void find_islands();
  void settle(double h);
  bool goes_on(int island);
  bool settled() const;
  void add_contacts(double h);
  void drop_unsolved();
  void drop_idle();
  static void find_worst(Attempt& attempt);
  void correct_prediction(Contact& c, double h);
  void place_friction(double h);
  void rebound(double h);
  bool extend_reach(bool last);

  void solve(double h);
  void cut_limits(size_t first, double h);

  System& system_;
  Data& data_;
  const KinematicBodies& kinematic_;
  Verification verification_;
  IslandResponse response_;
  PathCurvature curvature_;
  FrictionPlaces places_;
  Rebounds rebounds_;
  JointRanges ranges_;
  StandingFriction standing_;
  std::vector<Twist> twists_;
  std::vector<double> fastest_, way_;  // per root body, per shape [m]
  std::vector<int> beyond_;            // shapes that moved farther than their planes hold
};

}  // namespace hp
