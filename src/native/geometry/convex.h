// Convex shapes as vertex sets with a rounding radius, and the distance between two of them.
#pragma once
#include <vector>

#include "math/vec.h"

namespace hp {

// A view of world-space vertices, one array per coordinate so that support scans vectorise.
struct Points {
  const double *x = nullptr, *y = nullptr, *z = nullptr;
  int n = 0;
  Vec3 at(int i) const { return {x[i], y[i], z[i]}; }
  int support(Vec3 d) const;  // index of the vertex farthest along d
};

// What GJK asks of a shape: the hull of points, swept by a disc of radius `rim` across `axis`.
struct Support {
  Points points;
  Vec3 axis;
  double rim = 0;

  Support(Points p) : points(p) {}
  Support(Points p, Vec3 axis, double rim) : points(p), axis(axis), rim(rim) {}
  Vec3 farthest(Vec3 d) const { return swept(points.support(d), d); }
  // What vertex i, which lies farthest along d, is swept to.
  Vec3 swept(int i, Vec3 d) const {
    Vec3 p = points.at(i);
    return rim == 0 ? p : p + on_rim(d);
  }
  // From a disc's centre to the point of its rim that lies farthest along d; 0 across the disc.
  Vec3 on_rim(Vec3 d) const {
    Vec3 side = d - dot(d, axis) * axis;
    double length = norm(side);
    return length > 1e-12 * norm(d) ? (rim / length) * side : Vec3{};
  }
};

// Hull of the vertices, swept by a disc and grown by `radius`: sphere 1 vertex, capsule 2, box 8,
// any mesh hull n; cylinder 2 and a disc.
struct Convex {
  std::vector<Vec3> vertices;  // in the body's frame
  std::vector<Vec3> normals;   // outward face normals in the body's frame, for overlaps
  double radius = 0;
  Vec3 axis{0, 0, 1};  // unit, body's frame: of the disc
  double rim = 0;      // its radius; 0: none
  Vec3 center;       // of the bounding sphere, body's frame
  double bound = 0;  // its radius, rounding included

  std::vector<double> xyz;  // the vertices, one coordinate after the other

  void finish();   // fills center, bound and xyz
  void lay_out();  // fills center and xyz: all that distances need
};

// The shape at one pose.
struct PosedShape {
  const Convex* hull = nullptr;
  std::vector<double> xyz;   // x..., y..., z...
  std::vector<double> rest;  // of a skin with pose blend shapes: the same before it is posed
  Vec3 center;
  Mat3 R;
  Vec3 axis;  // of the disc, world
  Box3 box;   // rounding included

  void place(const Convex& c, const Mat3& R, Vec3 pos);
  Points points() const {
    int n = (int)hull->vertices.size();
    return {xyz.data(), xyz.data() + n, xyz.data() + 2 * n, n};
  }
  Support support() const { return {points(), axis, hull->rim}; }
  // How far the surface lies from the hull of the vertices, against n.
  double reach(Vec3 n) const {
    double r = hull->radius;
    return hull->rim == 0 ? r : r + hull->rim * norm(n - dot(n, axis) * axis);
  }
  // Smallest and largest of n.x over the rounded shape.
  double lowest(Vec3 n) const;
  double highest(Vec3 n) const { return -lowest(-n); }
};

// Where a search for nearest points ended, for the next one to begin with: vertices of the two.
struct Hint {
  int n = 0;  // 0: nothing
  int a[3] = {0, 0, 0}, b[3] = {0, 0, 0};
};

// Distance between two unrounded shapes (Gilbert, Johnson, Keerthi 1988) and the nearest points; 0 if
// they touch or overlap. Stops early with a lower bound once that exceeds `beyond`; pa - pb is then the
// unit direction, from b to a, that proves it. A `hint` of the same two shapes saves time.
double gjk(const Support& a, const Support& b, Vec3 guess, Vec3& pa, Vec3& pb, double beyond = 1e300,
           Hint* hint = nullptr);

// The shape, moved by a shift.
PosedShape displaced(const PosedShape& a, Vec3 shift);

struct Separation {
  double dist = 0;  // negative: depth along n
  Vec3 n;           // unit, from b to a
  Vec3 pa, pb;      // nearest points of the rounded shapes; pa - pb is parallel to n
};

// Distance of two rounded shapes, up to `beyond` (then only dist, a lower bound, and n). Where they
// overlap, n is the least-depth direction among the face normals of both and the line between their
// centres: exact for a point or sphere in a hull and for faces that touch, an upper bound of the depth
// otherwise. Without `way_out` an overlap is only said: dist is -1e300. A `guess` of n, if it is good, and
// a `hint` of the same two save time.
Separation separate(const PosedShape& a, const PosedShape& b, double beyond = 1e300, bool way_out = true,
                    Vec3 guess = {}, Hint* hint = nullptr);

// The same along a given direction: dist = min over a of n.x - max over b of n.x.
Separation separate_along(const PosedShape& a, const PosedShape& b, Vec3 n);

// Points where the faces of a and b that are nearest along n overlap, as pairs with
// pa - pb parallel to n, on both surfaces: up to `most` of them, none for point or edge contacts.
int face_manifold(const PosedShape& a, const PosedShape& b, Vec3 n, double tol, int most, Vec3* pa,
                  Vec3* pb);

}  // namespace hp
