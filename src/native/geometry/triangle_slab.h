// Bounding volumes of some triangles: a box along the world's axes, and a slab, a flatter box along
// their own axes. Their distances from a point are lower bounds of the triangles' distances.
#pragma once

#include <algorithm>
#include <cmath>
#include <limits>

#include "geometry/triangle.h"

namespace triangles {

struct Box {
  Vec lo, hi;
};

inline double box_distance2(const Box& b, Vec p) {
  const double x = std::max({b.lo.x - p.x, 0.0, p.x - b.hi.x});
  const double y = std::max({b.lo.y - p.y, 0.0, p.y - b.hi.y});
  const double z = std::max({b.lo.z - p.z, 0.0, p.z - b.hi.z});
  return x * x + y * y + z * z;
}

// A box along its own axes around the triangles of a node: flat where they are flat, so that its
// distance is nearly theirs. In single precision, rounded outwards; the axes are unit vectors to
// 1e-6.
struct Slab {
  float centre[3], half[3];
  float axes[3][3];
};

// A lower bound of the squared distance of a point from what is in a slab.
inline double slab_distance2(const Slab& b, Vec p) {
  const double x = p.x - b.centre[0], y = p.y - b.centre[1], z = p.z - b.centre[2];
  double sum = 0.0;
  for (int k = 0; k < 3; ++k) {
    const double along = b.axes[k][0] * x + b.axes[k][1] * y + b.axes[k][2] * z;
    const double out = std::max(std::abs(along) - b.half[k], 0.0);
    sum += out * out;
  }
  return (1.0 - 1e-6) * sum;
}

// The slab of some triangles in a box. Axes: the mean normal, the longest side of the box across
// it, and the direction across both.
inline Slab flat(const Triangle* triangles, int count, const Box& box) {
  Vec normal{0, 0, 0};
  for (int i = 0; i < count; ++i) {
    const Triangle& t = triangles[i];
    normal = normal + cross(t.b - t.a, t.c - t.a);
  }
  const Vec extent = box.hi - box.lo, middle = 0.5 * (box.lo + box.hi);
  const double size = norm(extent), length = norm(normal);
  Vec axes[3] = {{1, 0, 0}, {0, 1, 0}, {0, 0, 1}};
  if (length > 1e-9 * size * size) {  // else they face every way, or are slivers
    const Vec n = (1.0 / length) * normal;
    const Vec sides[3] = {{extent.x, 0, 0}, {0, extent.y, 0}, {0, 0, extent.z}};
    Vec longest{0, 0, 0};
    for (const Vec& side : sides) {
      const Vec across = side - dot(side, n) * n;
      if (dot(across, across) > dot(longest, longest)) longest = across;
    }
    if (norm(longest) > 1e-9 * size) {
      axes[0] = (1.0 / norm(longest)) * longest;
      axes[1] = cross(n, axes[0]);
      axes[2] = n;
    }
  }
  Slab s;
  double lo[3], hi[3];
  for (int k = 0; k < 3; ++k) {
    s.axes[k][0] = static_cast<float>(axes[k].x);
    s.axes[k][1] = static_cast<float>(axes[k].y);
    s.axes[k][2] = static_cast<float>(axes[k].z);
    lo[k] = std::numeric_limits<double>::infinity();
    hi[k] = -lo[k];
  }
  auto along = [&s](int k, Vec p) {
    return s.axes[k][0] * p.x + s.axes[k][1] * p.y + s.axes[k][2] * p.z;
  };
  for (int i = 0; i < count; ++i) {
    const Triangle& t = triangles[i];
    for (Vec p : {t.a - middle, t.b - middle, t.c - middle})
      for (int k = 0; k < 3; ++k) {
        const double x = along(k, p);
        lo[k] = std::min(lo[k], x);
        hi[k] = std::max(hi[k], x);
      }
  }
  Vec centre = middle;
  for (int k = 0; k < 3; ++k) centre = centre + 0.5 * (lo[k] + hi[k]) * axes[k];
  s.centre[0] = static_cast<float>(centre.x);
  s.centre[1] = static_cast<float>(centre.y);
  s.centre[2] = static_cast<float>(centre.z);
  const Vec shift = middle - Vec{s.centre[0], s.centre[1], s.centre[2]};
  const double room = 1e-12 * (size + norm(middle));
  for (int k = 0; k < 3; ++k) {
    const double off = along(k, shift);
    const double half = std::max(hi[k] + off, -(lo[k] + off)) + room;
    s.half[k] = std::nextafter(static_cast<float>(half), std::numeric_limits<float>::infinity());
  }
  return s;
}

}  // namespace triangles
