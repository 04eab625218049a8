// Soft layers in the step: what presses, its rows, and what came of them.
//
// A pair of a shape with samples and something, one of them soft, that may come near in a step is a
// candidate like others (`soft` is its number here): it connects islands, wakes who sleeps and is recorded as a
// touch. But it has no plane: pressures at an end pose are condensed into rows with a compliance
// (soft_rows.h), which are solved with the contacts of the hard frames. In an attempt:
//
//     gather      pairs within reach, appended to the candidates
//     look        pressures at the end pose: are they those that the rows had? An island where they
//                 are not is solved again, a few times (tuning.h, soft); what is then left is accepted
//     linearise   rows for the next solve, at the end pose looked at last
//     record      impulses of a step that is made, and the samples under pressure
//
// What a person presses is linearised first where the step would end with the velocity of the one before, by
// the samples' twist and without measuring: what rests, or goes on, is then solved once. Nothing else
// follows from that guess: the end pose of the solve is looked at as ever.
#pragma once
#include <vector>

#include "stepping/soft_pairs.h"
#include "stepping/soft_rows.h"
#include "stepping/soft_rules.h"

namespace hp {

class SoftContacts {
 public:
  // Lists the pairs; after the system is finished.
  void finish(const System& system);
  bool any() const { return pairs_.size() > 0; }
  int pairs() const { return pairs_.size(); }
  // Everything has been moved.
  void reset(const Model& m);

  // Marks in `busy` (per body) the roots of trees that may come to press something when no point of a shape
  // travels farther than `travel` [m].
  void mark_busy(const System& system, Data& data, const std::vector<double>& travel,
                 std::vector<char>& busy);
  void ease_gravity(const System& system, Data& data, double h) const {
    if (any()) rules_.ease_gravity(system, data, h);
  }
  void gather(const System& system, Data& data);
  // Chooses the rules of islands; what is hard has been checked at the pose of v_free.
  void choose_rules(const System& system, Data& data, double h);
  // `first`: nothing has been solved yet in this attempt.
  void look(const System& system, Data& data, double h, bool first);
  // With the twists that step.v makes.
  void linearise(const System& system, Data& data, double h, const std::vector<Twist>& twists);
  std::vector<Contact>& rows() { return rows_; }
  const std::vector<Contact>& rows() const { return rows_; }
  // The step is made, by the trees' shares of it (sub_stepping.h).
  void record(const System& system, Data& data, double h, const std::vector<double>& share);
  // A substep of length h [s] is over.
  void end_substep(double h) {
    if (any()) cells_.end_step(h);
  }
  // What the velocities that are kept have beyond those of the step that was recorded last, per dof.
  const std::vector<double>& kick() const { return rules_.kick(); }

  void save(std::vector<double>& out) const;
  const double* load(const double* in);
  // Of what was there before, what was known then: `body` gives each body's number in `old` (-1: new),
  // `now` each shape's number here (-1: gone).
  void adopt(const SoftContacts& old, const std::vector<int>& body, const std::vector<int>& now);

 private:
  // A pair that takes part in this attempt.
  struct Entry {
    int pair = 0, candidate = 0;
  };
  // Those of one group: active_[first] ... active_[end - 1].
  struct Group {
    int first = 0, end = 0;
    bool guessed = false;
    Twist twist;  // then: of its first body about the origin, relative to the layer
  };
  bool stiff(const System& system, Data& data, SoftPair& pair, double h) const;
  int island(const Data& data, const Group& group) const;
  void group_active();
  GroupRows& rows_of(const Group& group) { return rows_of_[&group - groups_.data()]; }
  void list_members(const Group& group);
  void list_pressed(Rule rule, double h, Vec3 way, const Group& group);
  Vec3 went(const System& system, Data& data, const Group& group) const;
  Twist about_origin(const System& system, const Data& data, int body) const;
  bool guess(const System& system, Data& data, double h, Group& group);
  bool measure(const System& system, Data& data, double h, const Group& group);
  Vec3 middle(const System& system, Poses& pose, const Group& group) const;
  PairImpulse applied(const Group& group, Vec3 about) const;
  bool has(const Group& group, int candidate) const;
  void add_rows(const System& system, Data& data, const Group& group, double h,
                const std::vector<Twist>& twists);
  Vec3 take_friction(const Group& group) const;
  const std::vector<BodyLoad>& loads_of(const Contact& row) const;
  void push_row(const System& system, Data& data, const Contact& c);
  void record_row(Data& data, const Contact& c) const;
  void record_group(const System& system, Data& data, double h, bool part, const Group& group);
  void record_points(const System& system, Data& data, const Entry& entry);

  SoftPairs pairs_;
  std::vector<Vec3> friction_;  // of groups, at their first pairs: impulse along the layer in the
                                // substep before, for the warm start
  FoamCells cells_;
  SoftRules rules_;
  std::vector<Entry> active_;  // group after group
  std::vector<Group> groups_;
  std::vector<Contact> rows_;
  std::vector<GroupRows> rows_of_;  // per group: what was looked at last
  RowMaker maker_;
  std::vector<Twist> twists_;  // that the velocities of the step before make
};

}  // namespace hp
