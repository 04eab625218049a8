// The frame's shortcut: which trees may touch anything on their path through a whole frame?
//
// Each shape goes from its start pose to its end pose; no point of it strays from the straight line
// between its ends by more than the shape's bulge (docs/physics.md, "The frame"). So it is clear of
// an obstacle if, in the order of their cost,
//
// - the pair's distance bound exceeds the shape's whole travel,
// - both ends lie on the outer side of all planes to a static by the bulge; or they and the poses at kPathParts - 1
//   places between them do by that of a part, which is smaller by the square of their number,
// - of two shapes of one person, seen from the root: the hulls of both ends of each are apart by
//   the bulges (GJK).
//
// Two trees that both move are apart if their distance exceeds what the two travel. Trees of pairs
// without such a proof are stepped through; all others arrive at their end pose.
#pragma once
#include <vector>

#include "collision/broad_phase.h"

namespace hp {

// Marks in `busy` (per body) the roots of trees that are not proved to stay clear.
void mark_busy_trees(const CollisionWorld& world, BroadPhase& broad_phase,
                     const std::vector<InitialOverlap>& overlaps, const Model& m, Poses& start,
                     Poses& end, const Sweep& sweep, std::vector<char>& busy);

}  // namespace hp
