#include "geometry/near_face.h"

#include <algorithm>
#include <cmath>

#include "math/elementary.h"
#include "tuning.h"

namespace hp {

namespace tune = tuning::geometry;

std::vector<FacePoint> convex_polygon(std::vector<FacePoint> pts) {
  std::sort(pts.begin(), pts.end(),
            [](FacePoint x, FacePoint y) { return x.u < y.u || (x.u == y.u && x.v < y.v); });
  if (pts.size() < 3) return pts;
  std::vector<FacePoint> hull(2 * pts.size());
  size_t k = 0;
  for (size_t i = 0; i < pts.size(); hull[k++] = pts[i++])
    while (k >= 2 && cross2(hull[k - 2], hull[k - 1], pts[i]) <= tune::kStraight) k--;
  for (size_t i = pts.size() - 1, floor = k + 1; i-- > 0; hull[k++] = pts[i])
    while (k >= floor && cross2(hull[k - 2], hull[k - 1], pts[i]) <= tune::kStraight) k--;
  hull.resize(k - 1);
  return hull;
}

namespace {

// Takes off what lies steeply above another point: of a coin or a card both sides are near. Three points
// are a triangle, which has no other side.
void drop_far_side(std::vector<FacePoint>& pts) {
  if (pts.size() < 2 || pts.size() == 3) return;
  double low = pts[0].height;
  for (FacePoint x : pts) low = std::min(low, x.height);
  std::sort(pts.begin(), pts.end(), [](FacePoint x, FacePoint y) { return x.u < y.u; });
  std::vector<FacePoint> kept;
  kept.reserve(pts.size());
  for (size_t i = 0; i < pts.size(); i++) {
    const FacePoint x = pts[i];
    const double aside = (x.height - low) / tune::kFarSide;  // no point farther along u is below it
    const auto is_above = [&](FacePoint y) {
      return x.height - y.height > tune::kFarSide * elementary::hypot(x.u - y.u, x.v - y.v);
    };
    bool above = false;  // mostly of a point beside it
    for (size_t k = i; k > 0 && !above && pts[k - 1].u >= x.u - aside; k--)
      above = is_above(pts[k - 1]);
    for (size_t k = i + 1; k < pts.size() && !above && pts[k].u <= x.u + aside; k++)
      above = is_above(pts[k]);
    if (!above) kept.push_back(x);
  }
  pts = std::move(kept);
}

}  // namespace

std::vector<FacePoint> near_face(const PosedShape& s, Vec3 n, Vec3 t, Vec3 b, double tol) {
  Points p = s.points();
  Support swept = s.support();
  double low = dot(n, p.at(p.support(-n)));
  std::vector<FacePoint> pts;
  pts.reserve(64);
  bool thin = true;                                 // no vertex is farther than tol
  const double rise = s.reach(n) - s.hull->radius;  // of the rim, above and below its centre
  const bool round = 2 * rise > tol || rise > tune::kDiscOnEdge * swept.rim;
  auto add = [&](Vec3 x) { pts.push_back({dot(t, x), dot(b, x), dot(n, x)}); };
  for (int i = 0; i < p.n; i++) {
    Vec3 x = p.at(i);
    if (dot(n, x) > low + tol) {
      thin = false;
      continue;
    }
    if (swept.rim == 0) {
      add(x);
    } else if (round) {
      add(x + swept.on_rim(-n));
    } else {
      for (int k = 0; k < kRoundCorners; k++)
        add(x + swept.on_rim(elementary::cos(0.25 * M_PI * k) * t +
                             elementary::sin(0.25 * M_PI * k) * b));
    }
  }
  if (thin) drop_far_side(pts);
  return convex_polygon(std::move(pts));
}

std::vector<FacePoint> clip(std::vector<FacePoint> face, const std::vector<FacePoint>& by) {
  for (size_t e = 0; e < by.size() && !face.empty(); e++) {
    FacePoint p = by[e], q = by[(e + 1) % by.size()];
    std::vector<FacePoint> out;
    out.reserve(face.size() + 2);
    for (size_t i = 0; i < face.size(); i++) {
      FacePoint c = face[i], d = face[(i + 1) % face.size()];
      double fc = cross2(p, q, c), fd = cross2(p, q, d);
      if (fc >= 0) out.push_back(c);
      if ((fc < 0) != (fd < 0)) {
        double f = fc / (fc - fd);
        out.push_back({c.u + f * (d.u - c.u), c.v + f * (d.v - c.v), 0});
      }
    }
    face = out;
  }
  return face;
}

}  // namespace hp
