// TriangleTree::below and meeting: the highest triangle under a point, and those around a box.
#include "geometry/bvh.h"
#include "tuning.h"

namespace hp {

namespace tune = tuning::geometry;

namespace {

// Where a vertical line at (x, y) meets a triangle that is no steeper than `least_z`; -1e300: not.
double height_at(const Vec3 v[3], double x, double y, double least_z) {
  const Vec3 n = cross(v[1] - v[0], v[2] - v[0]);
  if (std::fabs(n.z) <= least_z * norm(n)) return -1e300;
  bool left = false, right = false;
  for (int i = 0; i < 3; i++) {
    const Vec3 a = v[i], b = v[(i + 1) % 3];
    const double side = (b.x - a.x) * (y - a.y) - (b.y - a.y) * (x - a.x);
    left |= side > 0, right |= side < 0;
  }
  if (left && right) return -1e300;
  return v[0].z - (n.x * (x - v[0].x) + n.y * (y - v[0].y)) / n.z;
}

}  // namespace

double TriangleTree::below(Vec3 from, double least_z) const {
  double best = -1e300;
  int stack[tune::kMostDeep], top = 0;
  stack[top++] = 0;
  while (top > 0) {
    const Node& node = nodes_[stack[--top]];
    const Box3& b = node.box;
    if (from.x < b.lo.x || from.x > b.hi.x || from.y < b.lo.y || from.y > b.hi.y) continue;
    if (b.lo.z > from.z || b.hi.z <= best) continue;
    if (node.left >= 0) {
      stack[top++] = node.left, stack[top++] = node.right;
      continue;
    }
    for (int t = node.first; t < node.first + node.count; t++) {
      Vec3 v[3];
      triangle(t, v);
      const double z = height_at(v, from.x, from.y, least_z);
      if (z <= from.z && z > best) best = z;
    }
  }
  return best;
}

std::vector<int> TriangleTree::meeting(const Box3& box) const {
  std::vector<int> found;
  int stack[tune::kMostDeep], top = 0;
  stack[top++] = 0;
  while (top > 0) {
    const Node& node = nodes_[stack[--top]];
    if (!node.box.meets(box)) continue;
    if (node.left >= 0) {
      stack[top++] = node.right, stack[top++] = node.left;
      continue;
    }
    for (int t = node.first; t < node.first + node.count; t++) {
      Vec3 v[3];
      triangle(t, v);
      Box3 own;
      for (Vec3 x : v) own.add(x);
      if (own.meets(box)) found.push_back(t);
    }
  }
  return found;
}

}  // namespace hp
