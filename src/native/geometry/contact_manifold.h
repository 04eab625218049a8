// The area in which two near faces of convex shapes overlap, as a few points: where a box that
// rests on another one is carried.
//
// The vertices of each shape within `tol` of its nearest one along n make a face, projected on the
// plane across n; one face is clipped by the edges of the other (Sutherland and Hodgman 1974), and
// the extreme points of the rest along evenly turned directions are taken. A disc that lies flat
// counts as eight points of its rim.
#pragma once
#include "geometry/convex.h"

namespace hp {

// Pairs of points on both surfaces with pa - pb parallel to n (unit, from b to a): up to `most` of
// them; 0 where the shapes touch in a point or an edge alone. Lengths in [m].
int face_manifold(const PosedShape& a, const PosedShape& b, Vec3 n, double tol, int most, Vec3* pa,
                  Vec3* pb);

}  // namespace hp
