// Joints of people stay within their ranges (docs/physics.md, "Ranges of joints").
//
// For every angle of a joint (dynamics/joint_range.h) that a step would take beyond an end of its range
// there is a row, solved with the contacts like one without friction:
//
//   gap_end = gap + h (rate . omega) - shift >= target,    gap = +-(angle - end), in kRangeLever [m]
//
// linear at the middle of the joint's way, and corrected by what the end pose shows, pass by pass. The ends
// of a range are those of the anatomy or, where they are wider, of what the motion asks in this substep: so
// free motion has no row, and contact alone can put one to work. A joint that is beyond an end already goes
// back no faster than kRangeReturn.
//
// What gives way: where an island cannot be settled with rows, they are dropped for the rest of the substep;
// clearances and step lengths come after that. Nor is an island ever held open for a row alone. A person that
// comes out of an initial overlap has no ranges.
#pragma once
#include <vector>

#include "stepping/data.h"

namespace hp {

class JointRanges {
 public:
  // An attempt begins, of a step of length h.
  void begin(const System& system, Data& data, double h);
  // Checks the joints of people of open islands at step.end_qpos after step.v: sets `violated`, makes
  // rows of what is beyond, and corrects those that there are.
  void check(const System& system, Data& data, double h);
  // An island does not settle: from now on in the attempt it has the rows that it has. False if it has
  // none, or that was so already.
  static bool hold_fast(const System& system, Data& data, int island);
  // That does not cure it: its rows give way, by a level. False if it has none.
  bool give_way(const System& system, Data& data, int island);
  // The attempt has ended: islands that are settled but have joints too far beyond their ends are stuck,
  // and their rows give way in the next attempt, by a level.
  void end(const System& system, Data& data);
  // Is the joint of a row far enough off its end at step.end_qpos?
  static bool holds(const System& system, const Data& data, const RangeRow& row);

 private:
  static bool any(const System& system, const Data& data, int island);
  // What the joint may do in this substep.
  struct Window {
    bool known = false;
    double lower[3], upper[3];  // [rad]
    double about = 0;           // twists are counted as the nearest to this [rad]
  };

  const Window& window(const System& system, const Data& data, int person, int ball);
  void check_ball(const System& system, Data& data, int person, int ball, double h);
  void correct(const System& system, const Data& data, RangeRow& row, double h);
  static void yield(const System& system, Data& data, int island);
  static bool gone(const System& system, const Data& data, int person);
  double give(const System& system, const Data& data, int person) const;
  double target(const System& system, const Data& data, const RangeRow& row) const;

  double h_ = 0;                              // of the attempt [s]
  std::vector<std::vector<Window>> windows_;  // per person and ball
};

}  // namespace hp
