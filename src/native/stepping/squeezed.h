// What is squeezed between the heavy and the light leaves at a bounded speed.
//
// A tonne that comes down on a gram at 1 m/s wedges it out at 50 m/s: rigid bodies without
// restitution may do so, real ones give way first. So no object goes on faster than
// kSqueezeFactor times the fastest point of all else in its island at the substep's start, or than it
// came itself. The step itself is made as it was verified; the velocity that is kept is cut, which
// takes energy and never gives any. Blows, chains of them and levers stay below that factor.
#pragma once
#include <vector>

#include "stepping/data.h"

namespace hp {

class SqueezeLimit {
 public:
  // After the attempts at a substep: what moves together, and v*, with which it came.
  void begin(const System& system, const Data& data, const std::vector<double>& v_star);
  // At its end: cuts state.qvel.
  void cut(const System& system, Data& data);

 private:
  void find_speeds(const System& system, const Data& data);

  std::vector<int> island_;     // per root body
  std::vector<double> v_star_;  // at the substep's start
  // Found where an object is fast:
  std::vector<double> came_;              // speeds of trees [m/s]
  std::vector<double> fastest_, second_;  // of islands: the fastest and the second fastest tree's
  std::vector<int> leader_;               // per island: the fastest tree
  std::vector<Twist> twists_;
  bool any_ = false, found_ = false;
};

}  // namespace hp
