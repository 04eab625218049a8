// How far a shape moves as seen from an object: what is carried along moves far less than in the world.
//
// The distance of a shape from a rigid object changes by no more than the shape's travel in the object's
// frame. With c_0, c_1 the place of a point of the shape in that frame at two poses and r the chord of
// the rotation between them, a rigid shape moves no farther than |c_1 - c_0| of its centre plus r times
// its bounding radius; a skin hull no farther than the weighted bound of what its bodies move
// (collision_shape.h). Lengths in [m].
#pragma once
#include <algorithm>
#include <vector>

#include "collision/collision_world.h"
#include "collision/contact_candidate.h"
#include "collision/poses.h"

namespace hp {

// Upper bound of the travel of a shape between two poses, in the frame of `body`; kNoBound of skins
// with pose blend shapes, of which none is made.
constexpr double kNoBound = 1e300;
double relative_travel(const CollisionShape& shape, int body, const Poses& from, const Poses& to);

// What the two shapes of a pair move towards each other at most: `way`, per shape, or less where the second
// is a rigid object and both take part.
template <typename Pair>
double pair_travel(const CollisionWorld& world, const Pair& pair, const Poses& from,
                   const Poses& to, const std::vector<double>& way) {
  if (pair.other_shape < 0) return way[pair.shape];
  const double both = way[pair.shape] + way[pair.other_shape];
  const CollisionShape &a = world.shapes[pair.shape], &b = world.shapes[pair.other_shape];
  if (b.skin || a.body == b.body || !world.active[a.body] || !world.active[b.body]) return both;
  return std::min(both, relative_travel(a, b.body, from, to));
}

// A step is committed that moves shapes by `way`: what pairs with objects have moved together does not count
// against what is known of their distances.
void forget_shared_travel(const CollisionWorld& world, std::vector<BroadPhasePair>& pairs,
                          const Poses& from, const Poses& to, const std::vector<double>& way);

}  // namespace hp
