// Which hulls of a tree must leave an obstacle, and which of them together.
//
// Hulls that overlap the obstacle must leave it; so must those that a static cuts off: bodies whose
// bones (straight lines between neighbouring joints) connect them to the greater part of the tree
// only through the static are on its wrong side, however clear they are. The greater part is that
// with the most mass among those that carry at least a share of it, but not one that a closed mesh
// swallows whole (winding number). An object cuts off no hulls: bodies can go round it.
//
// Bodies that must leave and are neighbours in the skeleton leave together, by one displacement.
#pragma once
#include <vector>

#include "collision/obstacle.h"

namespace hp {

struct OverlapGroup {
  std::vector<int> shapes;
  std::vector<char> moves;  // per body: its joint leaves with the group
  std::vector<char> stays;  // per body: its joint is on the right side already
};

// The groups of one tree (`root`: its first body) and one obstacle that some of its shapes overlap. What
// it costs is added to `tests` (geometry/bvh.h).
std::vector<OverlapGroup> overlap_groups(const CollisionWorld& world, const Model& m, Poses& start,
                                         const Obstacle& o, int root,
                                         const std::vector<int>& overlapping, size_t& tests);

}  // namespace hp
