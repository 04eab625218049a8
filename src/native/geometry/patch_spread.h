// How far the pressure of a patch of contact lies from its centre, as a share of how far its points do.
//
// A patch is held by a few points, most of them corners; its pressure is spread over its area. Under uniform
// pressure, friction's moment about the normal is mu N times the mean distance of the area from its centroid
// c (the limit surface of a patch: Goyal, Ruina, Papadopoulos, "Planar sliding with dry friction", Wear 143,
// 1991). Over the triangle of c and an edge that passes c at the distance d, from x1 to x2 along it, with
// l = sqrt(x^2 + d^2),
//
//     integral of r = d/6 [x l + d^2 log((x + l)/d)] from x1 to x2.
//
// spread = mean distance of the area / mean distance of the points: 0.541 for the corners of a square, 2/3
// for the rim of a disc, 1/2 for the ends of an edge, 1 for a point alone; at most 1. Lengths in [m].
#pragma once
#include <vector>

#include "geometry/near_face.h"

namespace hp {

// A patch is made of one face, or of several that meet: the pieces of one body.
class PatchSpread {
 public:
  static constexpr double kDisc = 2.0 / 3.0, kEdge = 0.5;  // of a disc's rim, of an edge's ends

  // In the plane across n (unit).
  explicit PatchSpread(Vec3 n) : n_(n) { tangents(n, t_, s_); }

  // The face of `a` that lies nearest along -n, or the area in which it lies over that of `b`, along n;
  // b = nullptr: a surface without an end. The points are its corners, within `tol` of the nearest along n.
  void add_face(const PosedShape& a, const PosedShape* b, double tol);
  double spread() const;

 private:
  struct Area {
    double twice = 0;    // its area [m^2]
    FacePoint centre{};  // centroid, or the middle of an edge
  };
  Area area() const;

  Vec3 n_, t_, s_;
  std::vector<std::vector<FacePoint>> faces_;
  std::vector<FacePoint> points_;
  bool disc_ = false;  // the face is a whole disc
};

}  // namespace hp
