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
  Box3 box{load3(lo), load3(hi)};
  box.grow(c.radius);
  axis = rot * c.axis;
  if (c.rim > 0) {
    Vec3 side;
    for (int k = 0; k < 3; k++) side[k] = c.rim * std::sqrt(std::max(0.0, 1 - axis[k] * axis[k]));
    box.lo -= side;
    box.hi += side;
  }
  set_box(box);
}

// Of vertices that were posed one by one: neither rounded nor swept by a disc.
void PosedShape::find_box() const {
  const int n = (int)hull->vertices.size();
  double lo[3], hi[3];
  for (int c = 0; c < 3; c++) limits(&xyz[(size_t)c * n], n, lo[c], hi[c]);
  box_ = {load3(lo), load3(hi)};
  boxed_ = true;
}

void PosedShape::shift(Vec3 by) {
  const size_t n = hull->vertices.size();
  for (size_t k = 0; k < 3; k++)
    for (size_t i = 0; i < n; i++) xyz[k * n + i] += by[(int)k];
  center += by;
  if (boxed_) box_.lo += by, box_.hi += by;
}

PosedShape displaced(const PosedShape& a, Vec3 shift) {
  PosedShape b(a);
  if (norm2(shift) == 0) return b;
  b.shift(shift);
  return b;
}

}  // namespace hp
