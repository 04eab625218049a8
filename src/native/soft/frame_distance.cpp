#include "soft/frame_distance.h"

#include <cmath>

#include "geometry/gjk.h"
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
    f.hull_ = &s.posed, f.box_ = &soft.static_boxes[i];
  else
    f.tree_ = soft.trees[i].get();
  f.place_box();
  return f;
}

FrameDistance FrameDistance::of_shape(const CollisionWorld& world, const SoftWorld& soft,
                                      Poses& pose, int i) {
  FrameDistance f;
  f.layer_ = &soft.layer_of_shape(i);
  f.hull_ = &world.place(pose, i);
  f.box_ = &soft.shape_boxes[i];
  f.place_box();
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

void FrameDistance::place_box() {
  if (!hull_ || !box_->is) return;
  to_ = transposed(hull_->R * box_->axes);
  shift_ = mul_t(box_->axes, hull_->hull->center - box_->centre) - to_ * hull_->center;
}

// In the box's axes.
bool FrameDistance::nearest_on_box(Vec3 x, double within, FramePoint& out) const {
  const double radius = hull_->hull->radius;
  const Vec3 y = to_ * x + shift_;
  Vec3 away;
  for (int i = 0; i < 3; i++) {
    const double beyond = std::fabs(y[i]) - box_->half[i];
    away[i] = beyond > 0 ? std::copysign(beyond, y[i]) : 0;
  }
  const double d = norm(away);
  if (d > within + radius || d <= tune::kNoDistance) return false;
  out.n = (1 / d) * mul_t(to_, away);
  out.distance = d - radius;
  out.at = x - out.distance * out.n;
  return true;
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
