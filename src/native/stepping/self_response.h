// The response of a person to contact with itself: the limbs that touch give way, and nothing else.
//
// Forces inside a person cannot push all of it, and the motion says where every joint goes that
// nothing is in the way of. With M^^-1 a hand on the chest would tilt the trunk, swing the legs and
// move the root, all by a little. So self-contact is solved first, with only the dofs of the limbs
// that touch free to move:
//
//   v' = v* + G J^T p,    G the inverse of M^ cut down to those dofs, zero elsewhere.
//
// What the world does to the person goes through M^^-1 as always, and changes the self-contact
// impulses: all contacts are then solved together, from v' - M^^-1 J^T p, with p as the warm start,
// which is the answer if no other contact pushes. That is symmetric, with Coulomb's conditions on
// the sum.
//
// With Algorithm 1 of the paper a person's own torques (PJSC) push all of it, and so does
// self-contact.
#pragma once
#include <vector>

#include "stepping/data.h"

namespace hp {

class SelfResponse {
 public:
  // Solves self-contact alone, where `contacts` have any, to a tolerance [m/s]: v' and the impulses of
  // own(). False if there is
  // none, or if it cannot be solved by the joints between the parts that touch.
  bool solve(const System& system, Data& data, const std::vector<Contact>& contacts,
             double tolerance, ContactSolver& solver, double h);
  // The contacts within one person, in the order of `contacts`.
  const std::vector<Contact>& own() const { return own_; }
  bool is_own(const System& system, const Attempt& attempt, const Contact& c) const;
  const std::vector<double>& velocity() const { return v_; }  // v'
  double friction() const { return friction_; }  // what solve() missed of friction's law [m/s]
  // After solve() and brace(): v' - M^^-1 J^T p, from where all contacts are solved together. Takes v' and
  // J^T p with it.
  const std::vector<double>& without_own(const System& system, const Data& data);
  // After solve(): M^ (v' - v*) - J^T p, of the people who touch themselves, into their dofs of `out`:
  // what the joints that do not move hold. Free joints hold nothing.
  void brace(const System& system, const Data& data, std::vector<double>& out);

 private:
  void find_impulse(const System& system, const Data& data);
  void find_own(const System& system, const Attempt& attempt, const std::vector<Contact>& contacts);
  void make_room(const Model& m, int a, int b, bool whole);
  std::vector<double> resistance(const System& system, const Data& data) const;
  bool met(const System& system, const State& state, double h);

  std::vector<char> free_;  // per dof: it gives way
  InertiaFactor factor_;    // of the free dofs
  std::vector<Contact> own_;
  std::vector<char> touches_;  // per body: of people in contact with themselves
  std::vector<double> v_;      // v'
  double friction_ = 0;
  std::vector<double> impulse_;            // J^T p
  std::vector<double> change_, momentum_;  // v' - v*, and M of it
  std::vector<Twist> twists_;
};

}  // namespace hp
