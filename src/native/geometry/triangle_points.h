// The corners of a triangle as GJK reads points: coordinate by coordinate.
#pragma once
#include <algorithm>

#include "geometry/convex.h"

namespace hp {

struct TrianglePoints {
  double x[3], y[3], z[3];
  explicit TrianglePoints(const Vec3 v[3])
      : x{v[0].x, v[1].x, v[2].x}, y{v[0].y, v[1].y, v[2].y}, z{v[0].z, v[1].z, v[2].z} {}
  // Refers to this object.
  Support support() const { return Support{{x, y, z, 3}}; }
};

// Largest n.x over a triangle.
inline double highest(const Vec3 v[3], Vec3 n) {
  return std::max(dot(n, v[0]), std::max(dot(n, v[1]), dot(n, v[2])));
}

}  // namespace hp
