// Where a shape touches a triangle: along which direction does it?
//
// GJK has none where they are nearer than rounding, or overlap. The triangle's own normal is right where its face is met;
// of one that is met by an edge or a corner it says that the whole shape has gone through. So the triangle is
// moved off the middle of the shape, no farther than GJK needs to find a direction between the two.
#pragma once
#include "geometry/convex.h"

namespace hp {

// Point of a triangle nearest to p (Ericson 2005, 5.1.5).
Vec3 nearest_on(const Vec3 v[3], Vec3 p);

// From the triangle to a shape that touches or overlaps it, a unit vector; 0: none was found.
Vec3 touch_direction(const PosedShape& a, const Vec3 v[3]);

}  // namespace hp
