// Verification: are all gaps at the end pose as large as was asked?
//
// Contacts are solved with velocities, so their gaps at the end of a step are predictions along
// straight lines. The end pose itself is checked against every candidate (separating plane or pair
// of shapes): excess = gap - target [m]. A gap may miss its target by allowed(): solver tolerance,
// 2 % of the gap for paths that curve, more while a person separates from itself. Planes that the
// shape's path does not cross are forgiven by GapCheck, and what they had hidden is searched.
#pragma once
#include <vector>

#include "stepping/data.h"

namespace hp {

class Verification {
 public:
  // Checks the candidates of open islands at step.end: sets attempt.violated, and of the islands
  // `violated`, `worst` and `overdue`.
  void check(System& system, Data& data, double h);
  // The same before the first solve: where a person has contacts from the substep before, there is a
  // solve anyhow, and the person's candidates are checked after it, not before it too. The end pose,
  // whose coordinates are known, is made where a candidate is checked.
  void check_first(System& system, Data& data, double h);

 private:
  void check_candidate(System& system, Data& data, size_t i);
  void find_overdue(const System& system, Data& data) const;
  bool recall(System& system, Data& data);

  std::vector<char> recalled_;  // per candidate: its pair had contacts in the substep before
  std::vector<char> begun_;     // per person: one of theirs had
  std::vector<char> squeezed_;  // per person: a kinematic body is near
};

// Gap at the end pose minus target of candidate i [m], or a lower bound of it that is positive. Where
// its plane is forgiven, what it hides is to be searched; where very many such planes have been
// already, it is not forgiven.
double excess(System& system, Data& data, size_t i);
// The same, where a miss within what is allowed need not be looked at closer (GapCheck::excess).
double excess_over_slack(System& system, Data& data, size_t i);
// Appends the candidates that forgiven planes had hidden. True if there are any.
bool search_hidden(System& system, Data& data, double h);
// Charges the budget for what was posed at the end, and for the bounds of all candidates.
void spend_on_poses(Data& data);

// Where very many candidates of an island are violated, marks those alone that contacts are to be made
// of: of each shape the worst, and others whose planes differ from them.
void thin_out(const System& system, Data& data, int island);

// Marks islands where joints with ranges do not end within them as violated.
void check_limits(const System& system, Data& data, double h);

// Clearances give way where the targets of an island cannot be met all together: before a step is
// shortened, the gaps of the island may shrink to 0.1 mm, v_n >= -(dist - 0.1 mm)/h. False if it has
// given way already.
bool give_way(const System& system, Data& data, int island);
// Lowers the targets in islands that have given way.
void relax(const System& system, Attempt& attempt);

}  // namespace hp
