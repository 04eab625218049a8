// By which rule an island steps its soft layers (soft/pressing.h), and what follows for velocities.
//
// Islands of free objects alone, none of which meets anything hard, keep the energy of their springs
// (Rule::Mean); all others lose some of it (Rule::End). An object in the former has the velocity of the
// end of the step, one in flight that of a parabola on this grid, half a substep's gravity earlier:
// `level` says which, and what changes from one to the other gets that half. With Mean half of an
// impulse moves the step; `kick` is the other half, which the velocities that are kept have besides.
//
// Both rules know a press whose direction and area stay as they are. Over an edge, or fast past a ball, the
// normals turn within a step, and a push along those of its end may give more than the springs had. So the
// energy of such an island is balanced: of the pushes it keeps as much as leaves it
//
//     kinetic energy, beyond that of the velocity without contact
//         <=  what springs have given, less what dampers and friction have taken, and what is owed
//
// or, where nothing does, as comes nearest. Gravity acts alike on both sides. What a step with Mean has taken
// too much is owed to the island for as long as it presses: on a ball pressed in and out again both
// errors are the same.
#pragma once
#include <vector>

#include "soft/pressing.h"
#include "stepping/system.h"

namespace hp {

struct Data;

class SoftRules {
 public:
  // Everything has been moved; `any`: something is soft.
  void reset(const Model& m, bool any);
  // Objects in contact get half of a substep's gravity in v_free; the other half comes at its end.
  void ease_gravity(const System& system, Data& data, double h) const;

  // Chooses for islands by what is in them; what is hard has been checked at the pose of v_free.
  void choose(const System& system, const Data& data);
  Rule of(int island) const { return rules_[island]; }
  void set(int island, Rule rule) { rules_[island] = rule; }

  // A step is recorded: first this; then each row that pushes, by the trees that it pushes, and the energy
  // [J] that springs of an island have given where that is balanced; then what is kept of it; and at last
  // the kick of trees by their shares of the step (sub_stepping.h).
  void begin_record(const Model& m);
  void push(const System& system, const Data& data, int island, int tree_a, int tree_b,
            const Contact& row);
  bool balanced(int island) const { return balanced_[island]; }
  void give(int island, double energy) { given_[island] += energy; }
  void balance(const System& system, const Data& data);
  // The whole of a row's impulse.
  Vec3 whole(int island, const Contact& row) const {
    return row.impulse + kept_[island] * dot(row.impulse, row.n) * row.n;
  }
  void end_record(const System& system, Data& data, const std::vector<double>& share);
  const std::vector<double>& kick() const { return kick_; }

  void save(std::vector<double>& out) const;
  const double* load(const double* in);
  // `body` gives each body's number in `old` (-1: new).
  void adopt(const SoftRules& old, const std::vector<int>& body);

 private:
  double kept_share(const System& system, const Data& data, int island);

  // Whether soft contacts act on a tree, and by which rule.
  enum class Pressed : char { No, ByEnd, ByMean };

  std::vector<char> level_;           // per body
  std::vector<double> owed_;          // per body, of one of an island [J]
  std::vector<Rule> rules_;           // per root body that names an island
  std::vector<char> balanced_;        // likewise: free objects alone
  std::vector<int> island_;           // per root body, as the rules were chosen for
  std::vector<double> given_, kept_;  // likewise: energy [J]; share of the pushes beside the step
  std::vector<Pressed> pressed_;      // per root body, in the step that was recorded last
  std::vector<double> kick_, force_, rub_;  // per dof; impulses along normals and along layers
};

}  // namespace hp
