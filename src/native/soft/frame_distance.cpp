#include "soft/frame_distance.h"

#include <cmath>

#include "geometry/gjk.h"
#include "soft/sample_lanes.h"
#include "tuning.h"

namespace hp {

namespace tune = tuning::soft;

FrameDistance FrameDistance::of_static(const CollisionWorld& world, const SoftWorld& soft, int i) {
  FrameDistance f;
  const Static& s = world.statics[i];
  f.layer_ = &soft.layer_of_static(i);
  if (s.kind == Static::Kind::HalfSpace)
    f.plane_ = &s;
  else if (s.kind == Static::Kind::Hull)
    f.hull_ = &s.posed, f.box_ = &soft.static_boxes[i], f.way_ = soft.static_ways[i];
  else
    f.tree_ = soft.trees[i].get();
  return f;
}

FrameDistance FrameDistance::of_shape(const CollisionWorld& world, const SoftWorld& soft,
                                      Poses& pose, int i) {
  FrameDistance f;
  f.layer_ = &soft.layer_of_shape(i);
  f.hull_ = &world.place(pose, i);
  f.box_ = &soft.shape_boxes[i];
  if (f.box_->is) f.way_ = f.box_->way(f.hull_->R, f.hull_->center, f.hull_->hull->center);
  return f;
}

bool FrameDistance::nearest(Vec3 x, double within, int triangle, FramePoint& out) const {
  if (tree_) return nearest_on_mesh(x, within, triangle, out);
  out.thickness = layer_->thickness;
  if (hull_) return nearest_on_hull(x, within, out);
  out.n = plane_->n;
  out.distance = dot(plane_->n, x) - plane_->offset;
  out.at = x - out.distance * out.n;
  return out.distance <= within;
}

bool FrameDistance::nearest_on_hull(Vec3 x, double within, FramePoint& out) const {
  if (box_->is) return nearest_on_box(x, within, out);
  const double radius = hull_->hull->radius;
  const Points point{&x.x, &x.y, &x.z, 1};
  Vec3 pa, pb;
  const double d =
      gjk(Support(point), hull_->support(), x - hull_->center, pa, pb, within + radius);
  if (d > within + radius) return false;
  const Vec3 away = d > tune::kNoDistance ? x - pb : x - hull_->center;
  const double length = norm(away);
  if (length <= tune::kNoDistance) return false;  // a point in the middle: which way is open
  out.n = (1 / length) * away;
  out.distance = d - radius;
  out.at = x - out.distance * out.n;
  return true;
}

bool FrameDistance::holds(Vec3 x) const {
  if (!hull_ || !box_->is) return false;
  const Vec3 y = way_.to * x + way_.shift;
  bool in = true;
  for (int i = 0; i < 3; i++) in &= std::fabs(y[i]) <= box_->half[i] + tune::kNoDistance;
  return in;
}

// In the box's axes.
bool FrameDistance::nearest_on_box(Vec3 x, double within, FramePoint& out) const {
  const double radius = hull_->hull->radius;
  const Vec3 y = way_.to * x + way_.shift;
  Vec3 away;
  for (int i = 0; i < 3; i++) {
    const double beyond = std::fabs(y[i]) - box_->half[i];
    away[i] = beyond > 0 ? std::copysign(beyond, y[i]) : 0;
  }
  const double d = norm(away);
  if (d > within + radius || d <= tune::kNoDistance) return false;
  out.n = (1 / d) * mul_t(way_.to, away);
  out.distance = d - radius;
  out.at = x - out.distance * out.n;
  return true;
}

namespace {

using N = NearSamples;

// The nearest point is `distance` back along n, the layer above it has this thickness.
HP_INLINE void put(const SampleLanes& at, const Lanes (&n)[3], const Lanes& distance,
                   double thickness) {
  const Lanes zero = {};
  for (int k = 0; k < 3; k++) {
    at(N::Away, k) = n[k];
    at(N::At, k) = at(N::Hard, k) - distance * n[k];
  }
  at(N::Distance) = distance, at(N::LayerThickness) = zero + thickness;
}

HP_INLINE void put_box(const Mat3& to, Vec3 shift, Vec3 half, double radius, double thickness,
                       const SampleLanes& at) {
  const Lanes zero = {};
  const Lanes x = at(N::Hard, 0), y = at(N::Hard, 1), z = at(N::Hard, 2);
  Lanes away[3], n[3];
  for (int i = 0; i < 3; i++) {
    const double* row = to.m + 3 * i;
    const Lanes p = row[0] * x + row[1] * y + row[2] * z + shift[i];
    const Lanes beyond = (p < zero ? -p : p) - half[i];
    const Lanes out = p < zero ? -beyond : beyond;
    away[i] = beyond > zero ? out : zero;
  }
  const Lanes d = square_root(away[0] * away[0] + away[1] * away[1] + away[2] * away[2]);
  // Inside, or in the middle of a side, no way leads out: that is not found.
  const Lanes none = zero + tune::kNoDistance, far = zero + 1e300;
  const Lanes whole = 1.0 / (d > none ? d : none);
  for (int k = 0; k < 3; k++)
    n[k] = whole * (to.m[k] * away[0] + to.m[3 + k] * away[1] + to.m[6 + k] * away[2]);
  put(at, n, d - radius, thickness);
  at(N::Distance) = d > none ? at(N::Distance) : far;
}

}  // namespace

HP_CLONES void measure_plane(Vec3 n, double offset, double thickness, NearSamples& near) {
  const Lanes zero = {};
  for (int i = 0; i < near.size(); i += kLanes) {
    const SampleLanes at{near, i};
    const Lanes along[3] = {zero + n.x, zero + n.y, zero + n.z};
    put(at, along, n.x * at(N::Hard, 0) + n.y * at(N::Hard, 1) + n.z * at(N::Hard, 2) - offset,
        thickness);
  }
}

HP_CLONES void measure_box(const Mat3& to, Vec3 shift, Vec3 half, double radius, double thickness,
                           NearSamples& near) {
  for (int i = 0; i < near.size(); i += kLanes)
    put_box(to, shift, half, radius, thickness, {near, i});
}

void FrameDistance::measure_many(double within, NearSamples& near) const {
  if (plane_)
    measure_plane(plane_->n, plane_->offset, layer_->thickness, near);
  else
    measure_box(way_.to, way_.shift, box_->half, hull_->hull->radius, layer_->thickness, near);
  const double* distance = near[N::Distance];
  for (int i = 0; i < near.size(); i++) near.measured[i] = distance[i] <= within;
}

bool FrameDistance::nearest_on_mesh(Vec3 x, double within, int triangle, FramePoint& out) const {
  if (within <= 0) return false;
  triangles::Vec q{};
  double distance = 0;
  const int t = tree_->closest({x.x, x.y, x.z}, triangle, q, distance, within);
  if (t < 0 || distance <= tune::kNoDistance) return false;
  out.triangle = t;
  out.distance = distance;
  out.at = {q.x, q.y, q.z};
  out.n = (1 / distance) * (x - out.at);
  out.thickness = layer_->thickness;
  if (!layer_->corners.empty()) {
    const triangles::Vec share = tree_->shares(t, q);
    const Vec3& corner = layer_->corners[tree_->face(t)];
    out.thickness = share.x * corner.x + share.y * corner.y + share.z * corner.z;
  }
  return true;
}

}  // namespace hp
