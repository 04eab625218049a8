// Convex shapes as vertex sets with a rounding radius, and the distance between two of them.
#pragma once
#include <vector>

#include "vec.h"

namespace hp {

// A view of world-space vertices, one array per coordinate so that support scans vectorise.
struct Points {
  const double *x = nullptr, *y = nullptr, *z = nullptr;
  int n = 0;
  Vec3 at(int i) const { return {x[i], y[i], z[i]}; }
  int support(Vec3 d) const;  // index of the vertex farthest along d
};

// Hull of the vertices, grown by `radius`: sphere 1 vertex, capsule 2, box 8, any mesh hull n.
struct Convex {
  std::vector<Vec3> vertices;  // in the body's frame
  std::vector<Vec3> normals;   // outward face normals in the body's frame, for overlaps
  double radius = 0;
  Vec3 center;       // of the bounding sphere, body's frame
  double bound = 0;  // its radius, rounding included

  void finish();  // fills center and bound
};

// The shape at one pose.
struct Placed {
  const Convex* shape = nullptr;
  std::vector<double> xyz;  // x..., y..., z...
  Vec3 center;
  Mat3 R;
  Box3 box;  // rounding included

  void place(const Convex& c, const Mat3& R, Vec3 pos);
  Points points() const {
    int n = (int)shape->vertices.size();
    return {xyz.data(), xyz.data() + n, xyz.data() + 2 * n, n};
  }
  // Smallest and largest of n.x over the rounded shape.
  double lowest(Vec3 n) const;
  double highest(Vec3 n) const { return -lowest(-n); }
};

// Distance between two vertex hulls (Gilbert, Johnson, Keerthi 1988) and the nearest points; 0 if
// they touch or overlap. Stops early with a lower bound once that exceeds `beyond`.
double gjk(Points a, Points b, Vec3 guess, Vec3& pa, Vec3& pb, double beyond = 1e300);

struct Separation {
  double dist = 0;  // negative: depth along n
  Vec3 n;           // unit, from b to a
  Vec3 pa, pb;      // nearest points of the rounded shapes; pa - pb is parallel to n
};

// Distance of two rounded shapes, up to `beyond`. Where they overlap, n is the least-depth
// direction among the face normals of both and the line between their centres: exact for a point
// or sphere in a hull and for faces that touch, an upper bound of the depth otherwise.
Separation separate(const Placed& a, const Placed& b, double beyond = 1e300);

// The same along a given direction: dist = min over a of n.x - max over b of n.x.
Separation separate_along(const Placed& a, const Placed& b, Vec3 n);

// Points where the faces of a and b that are nearest along n overlap, as pairs with
// pa - pb parallel to n: up to `most` of them, none for point or edge contacts.
int face_manifold(const Placed& a, const Placed& b, Vec3 n, double tol, int most, Vec3* pa,
                  Vec3* pb);

}  // namespace hp
