// Convex shapes: the hull of some points, swept by a disc, grown by a radius.
//
// All primitives are exact in this form: a sphere is one point and a radius, a capsule two, a box
// eight points, a cylinder two points and a disc across its axis, any convex mesh its vertices.
// With S the unrounded shape (hull and disc) and r the radius, the support function is
//
//     h(n) = max over x in S of n.x + r |n|.
//
// Lengths in [m]; n, axis and other directions without length are unit vectors.
#pragma once
#include <vector>

#include "math/simd.h"
#include "math/vec.h"

namespace hp {

// A view of points in the world, one array per coordinate so that support scans vectorise.
struct Points {
  const double *x = nullptr, *y = nullptr, *z = nullptr;
  int n = 0;
  Vec3 at(int i) const { return {x[i], y[i], z[i]}; }
  // Index of the point farthest along d.
  int support(Vec3 d) const { return farthest(x, y, z, n, d.x, d.y, d.z); }
};

// The unrounded shape S in the world, as GJK asks for it: the hull of points, swept by a disc of
// radius `rim` across `axis`.
struct Support {
  Points points;
  Vec3 axis;
  double rim = 0;

  Support(Points p) : points(p) {}
  Support(Points p, Vec3 axis, double rim) : points(p), axis(axis), rim(rim) {}
  Vec3 farthest(Vec3 d) const { return swept(points.support(d), d); }
  // The point farthest along d that vertex i is swept to; i is the vertex farthest along d.
  Vec3 swept(int i, Vec3 d) const {
    Vec3 p = points.at(i);
    return rim == 0 ? p : p + on_rim(d);
  }
  // From a disc's centre to the point of its rim that lies farthest along d; 0 if d is along the
  // axis.
  Vec3 on_rim(Vec3 d) const {
    Vec3 side = d - dot(d, axis) * axis;
    double length = norm(side);
    return length > 1e-12 * norm(d) ? (rim / length) * side : Vec3{};
  }
};

// A convex shape in the frame of its body.
struct Convex {
  std::vector<Vec3> vertices;
  std::vector<Vec3>
      normals;  // outward normals of faces: directions that are tried where shapes overlap
  double radius = 0;
  Vec3 axis{0, 0, 1};  // of the disc
  double rim = 0;      // the disc's radius; 0: none
  Vec3 center;         // of the bounding sphere
  double bound = 0;    // its radius, rounding included

  std::vector<double> xyz;  // the vertices, one coordinate after the other

  void finish();   // fills center, bound and xyz
  void lay_out();  // fills center and xyz: all that distances need
};

// A convex shape at one pose, in the world.
struct PosedShape {
  const Convex* hull = nullptr;
  std::vector<double> xyz;   // vertices: x..., y..., z...
  std::vector<double> rest;  // of a skin with pose blend shapes: the same before it is posed
  Vec3 center;
  Mat3 R;
  Vec3 axis;  // of the disc

  void place(const Convex& c, const Mat3& R, Vec3 pos);
  // The vertices have been written: the box around them is found when it is asked for.
  void moved() { boxed_ = false; }
  void set_box(const Box3& box) { box_ = box, boxed_ = true; }
  // Around the shape, rounding included.
  const Box3& box() const {
    if (!boxed_) find_box();
    return box_;
  }
  void shift(Vec3 by);
  Points points() const {
    int n = (int)hull->vertices.size();
    return {xyz.data(), xyz.data() + n, xyz.data() + 2 * n, n};
  }
  Support support() const { return {points(), axis, hull->rim}; }
  // How far the surface lies beyond the hull of the vertices, along -n (and n).
  double reach(Vec3 n) const {
    double r = hull->radius;
    return hull->rim == 0 ? r : r + hull->rim * norm(n - dot(n, axis) * axis);
  }
  // Smallest and largest of n.x over the rounded shape.
  double lowest(Vec3 n) const {
    Points p = points();
    return dot(n, p.at(p.support(-n))) - reach(n);
  }
  double highest(Vec3 n) const { return -lowest(-n); }

 private:
  void find_box() const;

  mutable Box3 box_;
  mutable bool boxed_ = false;
};

// The shape, moved by a shift.
PosedShape displaced(const PosedShape& a, Vec3 shift);

}  // namespace hp
