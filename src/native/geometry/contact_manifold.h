// The area in which two near faces of convex shapes overlap, as a few points: where a box that
// rests on another one is carried.
//
// The near faces of the two (near_face.h), projected on the plane across n; one is clipped by the edges
// of the other, and the extreme points of the rest along evenly turned directions are taken.
#pragma once
#include "geometry/convex.h"

namespace hp {

// Pairs of points on both surfaces with pa - pb parallel to n (unit, from b to a): up to `most` of
// them; 0 where the shapes touch in a point or an edge alone. Lengths in [m].
int face_manifold(const PosedShape& a, const PosedShape& b, Vec3 n, double tol, int most, Vec3* pa,
                  Vec3* pb);

}  // namespace hp
