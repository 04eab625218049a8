#include "geometry/separation.h"

#include "geometry/direction_bounds.h"
#include "tuning.h"

namespace hp {

namespace tune = tuning::geometry;

Separation separate_along(const PosedShape& a, const PosedShape& b, Vec3 n) {
  Vec3 pa = a.support().farthest(-n) - a.hull->radius * n;
  double dist = dot(n, pa) - b.highest(n);
  return {dist, n, pa, pa - dist * n};
}

namespace {

// The best of some directions: that along which two shapes are farthest apart.
struct BestDirection {
  const PosedShape &a, &b;
  Separation best;
  DirectionBounds bounds;

  BestDirection(const PosedShape& a, const PosedShape& b) : a(a), b(b), bounds(a, b) {
    best.dist = -1e300;
  }
  void consider(Vec3 n) {
    if (bounds.under(n, best.dist)) return;
    bounds.add(n);
    Separation s = separate_along(a, b, n);
    if (s.dist > best.dist) best = s;
  }
  void consider_both_ways(Vec3 n) {
    double size = norm(n);
    if (size < 1e-9) return;
    consider((1 / size) * n);
    consider((-1 / size) * n);
  }

  // Face normals, and directions across discs, that are like n.
  void consider_faces_along(Vec3 n, double like) {
    const Vec3 in_a = mul_t(a.R, -n), in_b = mul_t(b.R, n);
    for (Vec3 f : a.hull->normals)
      if (dot(f, in_a) > like) consider(-(a.R * f));
    for (Vec3 f : b.hull->normals)
      if (dot(f, in_b) > like) consider(b.R * f);
    for (const PosedShape* c : {&a, &b}) {
      if (c->hull->rim == 0) continue;
      Vec3 side = n - dot(n, c->axis) * c->axis;  // length is its cosine to n
      if (norm(side) > like) consider((1 / norm(side)) * side);
    }
  }

  // All directions that are tried for an overlap.
  void consider_all() {
    for (Vec3 n : a.hull->normals) consider(-(a.R * n));
    for (Vec3 n : b.hull->normals) consider(b.R * n);
    Vec3 line = a.center - b.center;
    double length = norm(line);
    consider(length > 1e-9 ? (1 / length) * line : Vec3{0, 0, 1});
    for (const PosedShape* c : {&a, &b})
      if (c->hull->rim > 0) consider_both_ways(line - dot(line, c->axis) * c->axis);
    if (a.hull->rim > 0 && b.hull->rim > 0) consider_both_ways(cross(a.axis, b.axis));
  }
};

}  // namespace

Separation separate(const PosedShape& a, const PosedShape& b, double beyond, bool way_out,
                    Vec3 guess, Hint* hint) {
  double round = a.hull->radius + b.hull->radius;
  Vec3 pa, pb;
  if (norm2(guess) == 0) guess = a.center - b.center;
  double d = gjk(a.support(), b.support(), guess, pa, pb, beyond + round, hint);
  if (d > beyond + round) return {d - round, pa - pb, {}, {}};
  Vec3 n;
  Separation found;
  if (d > tune::kProvedApart) {
    n = (1 / d) * (pa - pb);
    found = {d - round, n, pa - a.hull->radius * n, pb + b.hull->radius * n};
    // Between flat ends of round shapes rounding tilts the line even farther off.
    if (d > tune::kNearFaces && a.hull->rim == 0 && b.hull->rim == 0) return found;
  }
  BestDirection search(a, b);
  if (d > tune::kProvedApart) {
    search.consider_faces_along(n, d < tune::kTouching ? tune::kLikeTouching : tune::kLikeNear);
    if (search.best.dist >= found.dist - tune::kSameDistance) {
      found.n = search.best.n;
      found.dist = search.best.dist;
      return found;
    }
    // A line of rounding's length may point anywhere: it counts only if it separates.
    search.consider(n);
    if (d > tune::kTouching || search.best.dist >= found.dist - tune::kSeparates) return found;
  }
  if (!way_out) return {-1e300, {}, {}, {}};
  search.consider_all();
  return search.best;
}

}  // namespace hp
