// The velocities that contacts make of v*, island by island: open ones are solved, all others keep
// what they have. So no island feels how another is solved.
//
// Of one island: self-contact first, then all of its contacts together (self_response.h). All are
// solved again while that finds joints touched that were held (untouched_joints.h); islands without
// such a joint keep what was found.
#pragma once
#include <vector>

#include "stepping/kinematic_bodies.h"
#include "stepping/self_response.h"
#include "stepping/untouched_joints.h"

namespace hp {

class IslandResponse {
 public:
  void begin(const System& system, Data& data) const {
    untouched_.begin(system, data.step.resistance, data.inertia);
  }
  // Solves the open islands for attempt.contacts, which end with the rows of joints' ranges: their
  // impulses and step.v.
  void solve(const System& system, Data& data, const KinematicBodies& kinematic, double h);

 private:
  void free_unheld(const System& system, Data& data);
  void solve_islands(const System& system, Data& data, const KinematicBodies& kinematic, double h);
  void solve_island(const System& system, Data& data, int island, double mass, double h);
  SolveReport respond(const System& system, Data& data, std::vector<Contact>& contacts,
                      double tolerance, double mass, double h, std::vector<double>& v);

  ContactSolver solver_;
  SelfResponse self_;
  UntouchedJoints untouched_;
  std::vector<int> island_;   // per contact
  std::vector<char> chosen_;  // per island: it is solved now
  std::vector<Contact> own_;  // contacts of one island
  std::vector<double> v_;
};

}  // namespace hp
