#include "geometry/triangle_touch.h"

#include "geometry/gjk.h"
#include "geometry/triangle_points.h"
#include "tuning.h"

namespace hp {

namespace tune = tuning::geometry;

Vec3 nearest_on(const Vec3 v[3], Vec3 p) {
  Vec3 ab = v[1] - v[0], ac = v[2] - v[0], ap = p - v[0];
  double d1 = dot(ab, ap), d2 = dot(ac, ap);
  if (d1 <= 0 && d2 <= 0) return v[0];
  Vec3 bp = p - v[1];
  double d3 = dot(ab, bp), d4 = dot(ac, bp);
  if (d3 >= 0 && d4 <= d3) return v[1];
  double vc = d1 * d4 - d3 * d2;
  if (vc <= 0 && d1 >= 0 && d3 <= 0) return v[0] + (d1 / (d1 - d3)) * ab;
  Vec3 cp = p - v[2];
  double d5 = dot(ab, cp), d6 = dot(ac, cp);
  if (d6 >= 0 && d5 <= d6) return v[2];
  double vb = d5 * d2 - d1 * d6;
  if (vb <= 0 && d2 >= 0 && d6 <= 0) return v[0] + (d2 / (d2 - d6)) * ac;
  double va = d3 * d6 - d5 * d4;
  if (va <= 0 && d4 >= d3 && d5 >= d6)
    return v[1] + ((d4 - d3) / ((d4 - d3) + (d5 - d6))) * (v[2] - v[1]);
  double sum = va + vb + vc;
  return sum > 0 ? v[0] + (vb / sum) * ab + (vc / sum) * ac : v[0];
}

Vec3 touch_direction(const PosedShape& a, const Vec3 v[3]) {
  const Vec3 out = nearest_on(v, a.center) - a.center;
  const double length = norm(out);
  if (length == 0) return {};
  for (double by = tune::kMovesOff; by <= tune::kMostMovedOff; by *= tune::kMovesOn) {
    const Vec3 off = (by / length) * out;
    const Vec3 moved[3] = {v[0] + off, v[1] + off, v[2] + off};
    Vec3 pa, pb;
    if (gjk(a.support(), TrianglePoints(moved).support(), -out, pa, pb) > tune::kTouching)
      return (1 / norm(pa - pb)) * (pa - pb);
  }
  return {};
}

}  // namespace hp
