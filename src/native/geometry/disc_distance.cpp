#include "geometry/disc_distance.h"

#include <algorithm>
#include <cmath>

#include "tuning.h"

namespace hp {

namespace tune = tuning::geometry;

namespace {

struct Disc {
  Vec3 axis;
  double rim;

  Vec3 across(Vec3 x) const { return x - dot(x, axis) * axis; }
  Vec3 nearest(Vec3 x) const {
    const Vec3 q = across(x);
    const double away = norm(q);
    return away > rim ? (rim / away) * q : q;
  }
  // e.(dd/dx) e
  double follows(Vec3 x, Vec3 e) const {
    const Vec3 q = across(x), f = across(e);
    const double away = norm(q);
    if (away <= rim) return norm2(f);
    const double along = dot(q, f) / away;
    return rim / away * (norm2(f) - along * along);
  }
};

bool from_line(const Vec3* m, const Disc& disc, DiscDistance& out) {
  const Vec3 way = m[1] - m[0];
  const double length = norm(way);
  if (length == 0) return false;
  const Vec3 e = (1 / length) * way;
  double t = 0.5 * length;
  for (int it = 0; it < tune::kDiscSteps; it++) {
    out.x = m[0] + t * e;
    out.d = disc.nearest(out.x);
    const double miss = dot(e, out.x - out.d), slope = 1 - disc.follows(out.x, e);
    if (std::fabs(miss) <= tune::kDiscMiss * norm(out.x - out.d)) {
      out.l[1] = t / length, out.l[0] = 1 - out.l[1];
      return out.l[0] >= 0 && out.l[1] >= 0;
    }
    if (slope < tune::kLeastSlope) return false;
    const double next = std::min(length, std::max(0.0, t - miss / slope));
    if (next == t) return false;  // beyond an end
    t = next;
  }
  return false;
}

bool from_plane(const Vec3* m, const Disc& disc, DiscDistance& out) {
  const Vec3 ab = m[1] - m[0], ac = m[2] - m[0];
  Vec3 n = cross(ab, ac);
  const double size = norm(n);
  if (size < tune::kNoTriangle) return false;
  n = (dot(n, m[0]) < 0 ? -1 / size : 1 / size) * n;
  const Vec3 side = disc.across(n);
  const double tilt = norm(side);
  if (tilt == 0) return false;
  out.d = (disc.rim / tilt) * side;
  const double dist = dot(n, m[0] - out.d);
  if (dist <= 0) return false;
  out.x = out.d + dist * n;
  const Vec3 up = (1 / size) * cross(ab, ac);
  const Vec3 ax = out.x - m[0];
  out.l[1] = dot(cross(ax, ac), up) / size;
  out.l[2] = dot(cross(ab, ax), up) / size;
  out.l[0] = 1 - out.l[1] - out.l[2];
  return out.l[0] >= 0 && out.l[1] >= 0 && out.l[2] >= 0;
}

}  // namespace

bool disc_distance(const Vec3* m, int n, Vec3 axis, double rim, DiscDistance& out) {
  const Disc disc{axis, rim};
  if (n == 2) return from_line(m, disc, out);
  if (n == 3) return from_plane(m, disc, out);
  out.x = m[0];
  out.d = disc.nearest(m[0]);
  return n == 1;
}

}  // namespace hp
