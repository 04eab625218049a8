// Distance of two rounded convex shapes, or the depth of their overlap, and the plane between them.
//
// Apart: the distance is that of the unrounded shapes (gjk.h) minus both radii, along the line
// between the nearest points. Shapes nearer than 2 mm take the normal of a face instead if it
// separates them as well: rounding tilts a short line between nearest points, and friction on a
// tilted plane creeps.
//
// Overlapping: n is the direction of least depth among the face normals of both shapes, the line
// between their centres and, of discs, directions across their axes. That is exact for a point or
// sphere in a hull and for faces that touch, an upper bound of the depth otherwise (least_overlap.h
// searches the whole sphere).
#pragma once
#include "geometry/convex.h"
#include "geometry/gjk.h"

namespace hp {

struct Separation {
  double dist = 0;  // negative: depth along n [m]
  Vec3 n;           // unit, from b to a
  Vec3 pa, pb;      // nearest points of the rounded shapes; pa - pb is parallel to n
};

// Up to a distance of `beyond`; farther, dist is a lower bound that exceeds it and only n is set
// besides. Without `way_out` no direction is sought for an overlap: dist is -1e300. A `guess` of n
// and a `hint` of the same two shapes save time.
Separation separate(const PosedShape& a, const PosedShape& b, double beyond = 1e300,
                    bool way_out = true, Vec3 guess = {}, Hint* hint = nullptr);

// The same along a given direction: dist = min over a of n.x - max over b of n.x.
Separation separate_along(const PosedShape& a, const PosedShape& b, Vec3 n);

}  // namespace hp
