// The face of a convex shape that lies nearest along a direction, as a convex polygon in the plane across it.
//
// The vertices of a shape within `tol` of its nearest one along -n make the face; of a shape that is thinner
// than that, those of its near side. A disc that is wholly that near, and does not stand on edge, counts as
// eight points of its rim, another as its nearest point alone: a round side is no face. Polygons are in
// counter-clockwise order; two points are an edge. Lengths in [m].
#pragma once
#include <vector>

#include "geometry/convex.h"

namespace hp {

// A point of a face: along the two tangents, and along the normal [m].
struct FacePoint {
  double u, v, height;
};

constexpr int kRoundCorners = 8;  // of a disc

// Twice the area of the triangle o a b, positive where it is counter-clockwise.
inline double cross2(FacePoint o, FacePoint a, FacePoint b) {
  return (a.u - o.u) * (b.v - o.v) - (a.v - o.v) * (b.u - o.u);
}

// The convex polygon around points (monotone chain).
std::vector<FacePoint> convex_polygon(std::vector<FacePoint> points);
// The face of a shape that lies nearest along -n; t and b are across n.
std::vector<FacePoint> near_face(const PosedShape& s, Vec3 n, Vec3 t, Vec3 b, double tol);
// A segment or polygon, cut by the edges of a convex polygon (Sutherland and Hodgman 1974).
std::vector<FacePoint> clip(std::vector<FacePoint> face, const std::vector<FacePoint>& by);

}  // namespace hp
