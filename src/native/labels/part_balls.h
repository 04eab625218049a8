// Balls around groups of a skin's vertices in a frame, without posing the vertices.
//
// A joint carries the vertices of a group that it moves; they lie in a ball that is fixed in its
// frame. A skinned vertex is a mean of where its joints carry it, so that it lies in the hull of the
// balls of all joints that carry its group: any ball around those is a ball around the group.
#pragma once
#include <cstddef>
#include <vector>

#include "math/vec.h"

namespace hp {

// What a joint carries of a group: the ball around it, in the joint's frame [m].
struct CarriedBall {
  int joint, group;
  Vec3 centre;
  double radius;
};

// Centres (groups, 3) and radii (groups,) [m] of balls around what joints carry of each group where
// it is wanted (groups,), in a frame whose joints are at `position` (joints, 3) and turned by
// `quaternion` (joints, 4), wxyz. The centre is that of the box around the centres of what is
// carried. A radius of -inf: nothing is.
void group_balls(const std::vector<CarriedBall>& carried, const double* position,
                 const double* quaternion, const unsigned char* wanted, size_t groups,
                 double* centre, double* radius);

}  // namespace hp
