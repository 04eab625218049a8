// The distance of a disc from a point, a line or a plane: where GJK's simplices end if one of two
// shapes is swept by a disc. Round shapes have no last simplex, and GJK converges on them only
// linearly (some twenty steps to rounding); the answer for the features that it has found takes a
// few.
//
// The disc has its centre in the origin, a radius r and an axis u. The point of it nearest to x is
// q = x - (x.u) u where |q| <= r, else r q/|q|. Of a line x(t) = m + t e the nearest point has
// e.(x - d(x)) = 0, by Newton's method:
//
//     d/dt e.(x - d) = 1 - e.(dd/dx) e,    dd/dx = (r/|q|) (P - q q^T/|q|^2),    P = 1 - u u^T
//
// (P itself inside the rim). Of a plane with the normal n the disc's point along n is the nearest.
// Lengths in [m].
#pragma once
#include "math/vec.h"

namespace hp {

// A disc and the point x = sum of l[k] m[k] nearest to it, of the affine hull of n points m.
struct DiscDistance {
  Vec3 x, d;  // the nearest points; d of the disc
  double l[3] = {1, 0, 0};
};

// False where they meet, where the search does not settle, or where x is not between the points.
bool disc_distance(const Vec3* m, int n, Vec3 axis, double rim, DiscDistance& out);

}  // namespace hp
