// A shape that overlapped something when the simulation started, on its way out; see depenetration.h.
#pragma once
#include <vector>

#include "math/vec.h"

namespace hp {

struct Inside {
  int shape = 0, other_static = -1, other_shape = -1;  // one of the two
  Vec3 exit;          // displaced by this the shape is clear, and on the right side [m]
  double out = 0;     // the shape is held clear displaced by (1 - out) exit; 1: it has come out
  double next = 0;    // what `out` will be at the end of the substep
  bool lost = false;  // no way out was found: nothing holds the pair until it is clear by itself
  double pace = 0;    // how far it should come in the substep [m]
  int stuck = 0;      // substeps in a row in which it made hardly any progress
  double depth() const { return (1 - out) * norm(exit); }
};

// Is this pair among those that overlapped?
inline bool is_inside(const std::vector<Inside>& all, int shape, int other_static, int other_shape) {
  for (const Inside& in : all)
    if (in.shape == shape && in.other_static == other_static && in.other_shape == other_shape)
      return true;
  return false;
}

}  // namespace hp
