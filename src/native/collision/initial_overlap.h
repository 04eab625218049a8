// A shape that overlapped a static or an object when the simulation started, and does not clear it
// yet; see depenetration.h.
#pragma once
#include <vector>

#include "math/vec.h"

namespace hp {

struct InitialOverlap {
  int shape = 0, other_static = -1, other_shape = -1;  // one of the two
  Vec3 exit;            // displaced by this the shape is clear, and on the right side [m]
  double progress = 0;  // the shape is held clear displaced by (1 - progress) exit; 1: it is out
  double next_progress = 0;  // what `progress` will be at the end of the substep
  bool no_exit = false;      // none was found: no contact holds the pair until it is clear
  double asked = 0;          // how far it should come in the substep [m]
  int stuck = 0;             // substeps in a row in which it made hardly any progress
  // There was no way out, but it is clear now, and held so from this substep on.
  bool held_clear() const { return no_exit && next_progress >= 1; }
  double depth() const { return (1 - progress) * norm(exit); }
};

// Is this pair among those that overlapped?
inline bool is_overlapping(const std::vector<InitialOverlap>& all, int shape, int other_static,
                           int other_shape) {
  for (const InitialOverlap& in : all)
    if (in.shape == shape && in.other_static == other_static && in.other_shape == other_shape)
      return true;
  return false;
}

}  // namespace hp
