// How near people are to static geometry, for reports: no step depends on it.
#pragma once
#include "collision/broad_phase.h"

namespace hp {

// Smallest distance of people's shapes from statics [m], up to `range`; infinity beyond. Uses the
// bounds of the broad phase where its list reaches that far.
double smallest_clearance(const CollisionWorld& world, const BroadPhase& broad_phase, Poses& p,
                          double range);

// The same of every shape, and the static that is nearest (-1: none within `range`); NaN for
// objects. Measures all pairs: slower, but at any poses.
void shape_clearances(const CollisionWorld& world, Poses& p, double range, double* dist,
                      int* nearest);

}  // namespace hp
