// By which rule an island steps its soft layers (soft/pressing.h), and what follows for velocities.
//
// Islands of free objects alone, none of which meets anything hard, keep the energy of their springs
// (Rule::Mean); all others lose some of it (Rule::End). An object in the former has the velocity of the
// end of the step, one in flight that of a parabola on this grid, half a substep's gravity earlier:
// `level` says which, and what changes from one to the other gets that half. With Mean half of an
// impulse moves the step; `kick` is the other half, which the velocities that are kept have besides.
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

  // A step is recorded: first this, then each row that pushes, by the trees that it pushes, then what
  // the kick is of trees by their shares of the step (sub_stepping.h).
  void begin_record(const Model& m);
  // Returns the whole of the row's impulse.
  Vec3 record(const System& system, const Data& data, Rule rule, int tree_a, int tree_b,
              const Contact& row);
  void end_record(const System& system, Data& data, const std::vector<double>& share);
  const std::vector<double>& kick() const { return kick_; }

  void save(std::vector<double>& out) const { out.insert(out.end(), level_.begin(), level_.end()); }
  const double* load(const double* in);
  // `body` gives each body's number in `old` (-1: new).
  void adopt(const SoftRules& old, const std::vector<int>& body);

 private:
  // Whether soft contacts act on a tree, and by which rule.
  enum class Pressed : char { No, ByEnd, ByMean };

  std::vector<char> level_;       // per body
  std::vector<Rule> rules_;       // per root body that names an island
  std::vector<Pressed> pressed_;  // per root body, in the step that was recorded last
  std::vector<double> kick_, force_;
};

}  // namespace hp
