// TriangleTree::gap: is a shape clear of all triangles? By separating directions alone.
#include <algorithm>

#include "geometry/bvh.h"
#include "geometry/gjk.h"
#include "geometry/triangle_points.h"
#include "geometry/triangle_touch.h"
#include "tuning.h"

namespace hp {

namespace tune = tuning::geometry;

namespace {

// The longest gap along an axis of the world.
double box_gap(const Box3& a, const Box3& b) {
  double most = -1e300;
  for (int k = 0; k < 3; k++) most = std::max({most, a.lo[k] - b.hi[k], b.lo[k] - a.hi[k]});
  return most;
}

// A shape, and directions with what is lowest of it along them.
struct Witnesses {
  const PosedShape& a;
  SeparatingAxes& axes;
  double low[SeparatingAxes::kMost];

  Witnesses(const PosedShape& a, SeparatingAxes& axes) : a(a), axes(axes) {
    for (int k = 0; k < SeparatingAxes::kMost; k++)
      low[k] = norm2(axes.n[k]) > 0 ? a.lowest(axes.n[k]) : -1e300;
  }
  double apart(const Box3& box) const {
    double most = box_gap(box, a.box());
    for (int k = 0; k < SeparatingAxes::kMost && most <= 0; k++)
      if (low[k] > -1e300) most = std::max(most, low[k] - box.highest(axes.n[k]));
    return most;
  }
  double apart(const Vec3 v[3]) const {
    double most = -1e300;
    for (int k = 0; k < SeparatingAxes::kMost; k++)
      if (low[k] > -1e300) most = std::max(most, low[k] - highest(v, axes.n[k]));
    return most;
  }
  // Where none of them separates the triangle; remembers a direction that does.
  double measure(const Vec3 v[3], double look) {
    const TrianglePoints triangle(v);
    Vec3 pa, pb;
    const Vec3 guess = a.center - (1.0 / 3) * (v[0] + v[1] + v[2]);
    const double r = a.hull->radius,
                 d = gjk(a.support(), triangle.support(), guess, pa, pb, look + r);
    if (d > tune::kProvedApart) {
      const Vec3 n = (1 / norm(pa - pb)) * (pa - pb);
      const double lowest = a.lowest(n), gap = lowest - highest(v, n);
      if (gap <= 0) return gap;
      axes.n[axes.next] = n;
      low[axes.next] = lowest;
      axes.next = (axes.next + 1) % SeparatingAxes::kMost;
      return gap;
    }
    const Vec3 n = cross(v[1] - v[0], v[2] - v[0]);
    const double length = norm(n);
    if (length < tune::kNoTriangle) return -tune::kMeshTouch;  // no normal to measure along
    const Vec3 up = (1 / length) * n;
    return std::max(a.lowest(up) - dot(up, v[0]), a.lowest(-up) + dot(up, v[0]));
  }
  // The least depth that any direction says, of those that are known and that of the touch.
  double depth(const Vec3 v[3], double measured) const {
    const Vec3 touch = touch_direction(a, v);
    const double touches = norm2(touch) > 0 ? a.lowest(touch) - highest(v, touch) : -1e300;
    return std::max({measured, apart(v), touches});
  }
};

}  // namespace

double TriangleTree::gap(const PosedShape& a, double look, SeparatingAxes& axes, size_t& tests,
                         bool least_depth) const {
  static thread_local std::vector<int> stack;
  Witnesses witnesses(a, axes);
  double least = 1e300;
  stack.assign(1, 0);
  while (!stack.empty()) {
    const Node& node = nodes_[stack.back()];
    stack.pop_back();
    tests += tune::kBoxTests;
    const double apart = witnesses.apart(node.box);
    if (apart > 0) {
      least = std::min(least, apart);
    } else if (node.left >= 0) {
      stack.push_back(node.left);
      stack.push_back(node.right);
    } else {
      for (int i = node.first; i < node.first + node.count; i++) {
        Vec3 v[3];
        triangle(i, v);
        const double known = witnesses.apart(v);
        tests += known > 0 ? tune::kBoxTests : tune::kMeasureTests;
        double gap = known > 0 ? known : witnesses.measure(v, look);
        if (gap >= least) continue;
        if (gap < 0 && least_depth) {
          tests += tune::kTouchTests;
          gap = witnesses.depth(v, gap);
        }
        least = std::min(least, gap);
      }
    }
  }
  return least;
}

}  // namespace hp
