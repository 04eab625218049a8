// Upper bounds of how far shapes move between two poses: all that broad phase needs to know of
// them.
//
// A rigid shape moves no farther than its centre does plus 2 sin(angle / 2) times its bounding
// radius. A skin hull moves no farther than the weighted bound of what its influencing bodies move
// (collision_shape.h), plus gain |dR| for each joint with pose blend shapes.
#pragma once
#include <vector>

#include "collision/poses.h"

namespace hp {

// Of all shapes of active bodies, in the world [m]; zero for the others.
void travel_bounds(const std::vector<CollisionShape>& shapes, const Poses& from, const Poses& to,
                   const std::vector<char>& active, std::vector<double>& travel);

// The same as seen from the root of each shape's tree. Distances between hulls of one person depend
// on the pose alone, not on where the person is: only this travel counts between them.
void travel_bounds_in_root_frame(const std::vector<CollisionShape>& shapes, const Model& m,
                                 const Poses& from, const Poses& to,
                                 const std::vector<char>& active, std::vector<double>& travel);

}  // namespace hp
