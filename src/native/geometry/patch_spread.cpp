#include "geometry/patch_spread.h"

#include <algorithm>
#include <cmath>

#include "math/elementary.h"
#include "tuning.h"

namespace hp {

namespace tune = tuning::geometry;

namespace {

double area2(const std::vector<FacePoint>& face) {
  double sum = 0;
  for (size_t k = 1; k + 1 < face.size(); k++) sum += cross2(face[0], face[k], face[k + 1]);
  return sum;
}

// log((x + l)/d) for x of any sign.
double arc(double x, double l, double d) {
  return x >= 0 ? elementary::log((x + l) / d) : -elementary::log((l - x) / d);
}

// Integral of the distance from c over the triangle of c and the edge p q, negative where that is clockwise.
double edge_moment(FacePoint c, FacePoint p, FacePoint q) {
  const double length = elementary::hypot(q.u - p.u, q.v - p.v), twice = cross2(c, p, q);
  if (std::fabs(twice) <= tune::kStraight) return 0;
  const double d = std::fabs(twice) / length;
  const double x1 = ((p.u - c.u) * (q.u - p.u) + (p.v - c.v) * (q.v - p.v)) / length;
  const double x2 = x1 + length;
  const double l1 = elementary::hypot(x1, d), l2 = elementary::hypot(x2, d);
  const double moment = d / 6 * (x2 * l2 - x1 * l1 + d * d * (arc(x2, l2, d) - arc(x1, l1, d)));
  return twice > 0 ? moment : -moment;
}

double mean_distance(FacePoint c, const std::vector<FacePoint>& points) {
  double sum = 0;
  for (FacePoint p : points) sum += elementary::hypot(p.u - c.u, p.v - c.v);
  return sum / (double)points.size();
}

bool same_area(const std::vector<FacePoint>& face, double twice) {
  return std::fabs(area2(face) - twice) < tune::kSameArea * twice;
}

}  // namespace

void PatchSpread::add_face(const PosedShape& a, const PosedShape* b, double tol) {
  std::vector<FacePoint> face = near_face(a, n_, t_, s_, tol);
  const bool alone = faces_.empty();
  const double own = a.hull->rim > 0 && face.size() == kRoundCorners ? area2(face) : 0;
  double others = 0;
  if (b) {
    std::vector<FacePoint> other = near_face(*b, -n_, t_, s_, tol);
    if (b->hull->rim > 0 && other.size() == kRoundCorners) others = area2(other);
    if (other.size() < face.size()) std::swap(face, other);
    if (other.size() > 2) face = clip(std::move(face), other);
  }
  disc_ = alone && ((own > 0 && same_area(face, own)) || (others > 0 && same_area(face, others)));
  points_.insert(points_.end(), face.begin(), face.end());
  faces_.push_back(std::move(face));
}

PatchSpread::Area PatchSpread::area() const {
  Area sum;
  const FacePoint o = points_[0];
  for (const std::vector<FacePoint>& face : faces_)
    for (size_t k = 1; k + 1 < face.size(); k++) {
      const double part = cross2(face[0], face[k], face[k + 1]);
      sum.twice += part;
      sum.centre.u += part / 3 * (face[0].u + face[k].u + face[k + 1].u - 3 * o.u);
      sum.centre.v += part / 3 * (face[0].v + face[k].v + face[k + 1].v - 3 * o.v);
    }
  const bool flat = sum.twice > tune::kStraight;
  sum.centre = flat ? FacePoint{o.u + sum.centre.u / sum.twice, o.v + sum.centre.v / sum.twice, 0}
                    : FacePoint{0.5 * (o.u + points_.back().u), 0.5 * (o.v + points_.back().v), 0};
  if (!flat) sum.twice = 0;
  return sum;
}

double PatchSpread::spread() const {
  if (points_.size() < 2) return 1;
  if (disc_) return kDisc;
  const Area all = area();
  if (all.twice == 0) return kEdge;
  double moment = 0;
  for (const std::vector<FacePoint>& face : faces_)
    for (size_t k = 0; face.size() > 2 && k < face.size(); k++)
      moment += edge_moment(all.centre, face[k], face[(k + 1) % face.size()]);
  return std::min(1.0, 2 * moment / (all.twice * mean_distance(all.centre, points_)));
}

}  // namespace hp
