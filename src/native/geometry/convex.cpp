#include "geometry/convex.h"

namespace hp {

void Convex::lay_out() {
  Box3 box;
  for (Vec3 v : vertices) box.add(v);
  center = 0.5 * (box.lo + box.hi);
  xyz.clear();
  for (int k = 0; k < 3; k++)
    for (Vec3 v : vertices) xyz.push_back(v[k]);
}

void Convex::finish() {
  lay_out();
  bound = 0;
  for (Vec3 v : vertices) {
    double along = dot(axis, v - center), across = norm(v - center - along * axis);
    bound = std::max(bound, elementary::hypot(along, across + rim));
  }
  bound += radius;
}

void PosedShape::place(const Convex& c, const Mat3& rot, Vec3 pos) {
  hull = &c;
  R = rot;
  center = pos + rot * c.center;
  int n = (int)c.vertices.size();
  xyz.resize(3 * n);
  double at[3], lo[3], hi[3];
  store3(at, pos);
  transform(c.xyz.data(), n, rot.m, at, xyz.data(), lo, hi);
  box = {load3(lo), load3(hi)};
  box.grow(c.radius);
  axis = rot * c.axis;
  if (c.rim == 0) return;
  Vec3 side;
  for (int k = 0; k < 3; k++) side[k] = c.rim * std::sqrt(std::max(0.0, 1 - axis[k] * axis[k]));
  box.lo -= side;
  box.hi += side;
}

PosedShape displaced(const PosedShape& a, Vec3 shift) {
  PosedShape b(a);
  if (norm2(shift) == 0) return b;
  const size_t n = a.hull->vertices.size();
  for (size_t k = 0; k < 3; k++)
    for (size_t i = 0; i < n; i++) b.xyz[k * n + i] += shift[(int)k];
  b.center += shift;
  b.box.lo += shift, b.box.hi += shift;
  return b;
}

}  // namespace hp
