// GJK: the distance between two convex shapes and their nearest points.
//
// Gilbert, Johnson and Keerthi (1988), "A fast procedure for computing the distance between complex
// objects in three-dimensional space". In the Minkowski difference A - B, whose distance from the
// origin is the distance of A and B, a simplex of up to four support points is kept. In turn, v is
// the point of the simplex nearest to the origin (Ericson 2005, "Real-Time Collision Detection",
// ch. 5), the simplex is reduced to the vertices that carry v, and the support point w along -v is
// added, until none is nearer: v.v - v.w <= 1e-13 v.v.
//
// Every v with v.w > 0 is a separating direction and proves the lower bound v.w / |v| of the
// distance: with `beyond` the search stops as soon as that exceeds it, and where rounding makes a
// flat simplex say something else, the bound is believed.
//
// Where one of the two is swept by a disc, each simplex's features are asked for their exact distance
// too (disc_distance.h), those of the last search first: no simplex ends a search on a round side.
//
// Limits: 64 iterations; distances under some nanometres may be reported as 0. Of discs the rim is
// exact, not a polygon.
#pragma once
#include "geometry/convex.h"

namespace hp {

// Where a search ended, for the next one of the same two shapes to begin with: vertices of the two.
struct Hint {
  int n = 0;  // 0: nothing
  int a[3] = {0, 0, 0}, b[3] = {0, 0, 0};
};

// Distance between two unrounded shapes [m], with nearest points pa and pb; 0 if they touch or
// overlap. If it exceeds `beyond`, a lower bound greater than that, and then pa - pb is the unit
// direction, from b to a, that proves it. `guess`: a direction from b to a; `hint`, if any, is read
// and updated.
double gjk(const Support& a, const Support& b, Vec3 guess, Vec3& pa, Vec3& pb,
           double beyond = 1e300, Hint* hint = nullptr);

}  // namespace hp
