// Soft layers in the step: which pairs may press, their rows, and what came of them.
//
// A pair of a shape with samples and something, one of them soft, that may come near in a step is a
// candidate like others (`soft` is its number here): it connects islands, wakes who sleeps and is recorded as a
// touch. But it has no plane: pressures at an end pose are condensed into rows with a compliance
// (soft/condensation.h), which are solved with the contacts of the hard frames. In an attempt:
//
//     gather      pairs within reach, appended to the candidates
//     look        pressures at the end pose: are they those that the rows had? An island where they
//                 are not is solved again, a few times (tuning.h, soft); what is then left is accepted
//     linearise   rows for the next solve, at the end pose looked at last
//     record      impulses of a step that is made, and the samples under pressure
//
// Rules (soft/pressing.h): islands of free objects alone, none of which meets anything hard, keep the energy
// of their springs (Rule::Mean); all others lose some of it (Rule::End). An object in the former has the
// velocity of the end of the step, one in flight that of a parabola on this grid, half a substep's
// gravity earlier: `level` says which, and what changes from one to the other gets that half.
#pragma once
#include <vector>

#include "soft/condensation.h"
#include "stepping/system.h"

namespace hp {

struct Data;

class SoftContacts {
 public:
  // Lists the pairs; after the system is finished.
  void finish(const System& system);
  bool any() const { return !pairs_.empty(); }
  // Everything has been moved.
  void reset(const Model& m);

  // Marks in `busy` (per body) the roots of trees that may come to press something when no point of a shape
  // travels farther than `travel` [m].
  void mark_busy(const System& system, Data& data, const std::vector<double>& travel,
                 std::vector<char>& busy);
  // Objects in contact get half of a substep's gravity in v_free; the other half comes at its end.
  void ease_gravity(const System& system, Data& data, double h) const;
  void gather(const System& system, Data& data);
  // Chooses the rules of islands; what is hard has been checked at the pose of v_free.
  void choose_rules(const System& system, Data& data, double h);
  void look(const System& system, Data& data, double h);
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
  const std::vector<double>& kick() const { return kick_; }

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
  // Whether soft contacts act on a tree, and by which rule.
  enum class Pressed : char { No, ByEnd, ByMean };
  void list_pair(const System& system, int shape, int other_static, int other_shape);
  bool chooses_first(const System& system, int a, int b) const;
  bool near(const System& system, Data& data, SoftPair& pair, double reach);
  double room(const System& system, Poses& start, const SoftPair& pair, double range) const;
  bool takes_part(const System& system, const SoftPair& pair) const;
  bool stiff(const System& system, Data& data, SoftPair& pair, double h) const;
  static double way(const System& system, Data& data, const SoftPair& pair);
  static double travelled(const System& system, const SoftPair& pair);
  Vec3 middle(const System& system, Poses& pose, const SoftPair& pair) const;
  PairImpulse applied(int candidate, Vec3 about) const;
  Rule rule(const Data& data, int candidate) const;
  void add_rows(const System& system, Data& data, const Entry& entry, double h,
                const std::vector<Twist>& twists);
  void record_row(const System& system, Data& data, const Contact& c);
  void record_points(const System& system, Data& data, const Entry& entry);
  void add_kick(const System& system, Data& data, const std::vector<double>& share);

  std::vector<SoftPair> pairs_;
  std::vector<Vec3>
      friction_;  // per pair: impulse along the layer in the substep before, for the warm start
  std::vector<char> level_;  // per body
  FoamCells cells_;
  std::vector<Entry> active_;
  std::vector<Contact> rows_;
  std::vector<Rule> rules_;       // per root body that names an island
  std::vector<Pressed> pressed_;  // per root body, in the step that was recorded last
  std::vector<double> kick_, force_;
  std::vector<PatchPoint> points_;
  std::vector<int> patch_;
};

}  // namespace hp
