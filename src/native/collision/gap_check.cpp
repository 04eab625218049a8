#include "collision/gap_check.h"

#include <cmath>

#include "geometry/gjk.h"
#include "geometry/separation.h"
#include "geometry/triangle_points.h"
#include "tuning.h"

namespace hp {

namespace tune = tuning::collision;

namespace {

// Corner k of the polygon around a disc, from its centre: the same material point at every pose.
Vec3 rim_corner(const PosedShape& s, int k) {
  Vec3 t, b;
  tangents(s.hull->axis, t, b);
  double angle = 2 * M_PI * k / tune::kRimSides,
         r = s.hull->rim / elementary::cos(M_PI / tune::kRimSides);
  return s.R * (r * (elementary::cos(angle) * t + elementary::sin(angle) * b));
}

// Coordinates of points, as GJK reads them: the vertices of a shape at two poses.
struct SweptPoints {
  std::vector<double> xyz;
  int n;  // vertices at one pose
  explicit SweptPoints(int n) : xyz(6 * (size_t)n), n(n) {}
  void set(int i, Vec3 p) {
    double *x = xyz.data(), *y = x + 2 * n, *z = y + 2 * n;
    x[i] = p.x, y[i] = p.y, z[i] = p.z;
  }
  Support support() const {
    const double *x = xyz.data(), *y = x + 2 * n, *z = y + 2 * n;
    return Support{{x, y, z, 2 * n}};
  }
  // The longest way from a vertex at one pose to the same at the other.
  double farthest() const {
    const double *x = xyz.data(), *y = x + 2 * n, *z = y + 2 * n;
    double most = 0;
    for (int i = 0; i < n; i++)
      most = std::max(most, norm2(Vec3{x[n + i] - x[i], y[n + i] - y[i], z[n + i] - z[i]}));
    return std::sqrt(most);
  }
};

// The swept hull of the candidate's shape; `back` and `shift` take the end into the start frame of
// the other. A disc is replaced by the polygon around it.
SweptPoints swept_points(const PosedShape& a0, const PosedShape& a1, const ContactCandidate& c,
                         const Mat3& back, Vec3 shift) {
  const bool disc = a0.hull->rim > 0;
  const Points p0 = a0.points(), p1 = a1.points();
  const int n = p0.n * (disc ? tune::kRimSides : 1);
  auto corner = [&](const PosedShape& s, Points p, int i) {
    return disc ? p.at(i / tune::kRimSides) + rim_corner(s, i % tune::kRimSides) : p.at(i);
  };
  SweptPoints swept(n);
  for (int i = 0; i < n; i++) {
    Vec3 p = corner(a0, p0, i) + c.from, q = corner(a1, p1, i) + c.shift();
    if (c.other_shape >= 0) q = back * q + shift;
    swept.set(i, p), swept.set(n + i, q);
  }
  return swept;
}

}  // namespace

const PathBounds& GapCheck::paths(const Model& m, const Poses& start, const Poses& end) {
  if (paths_stamp_ != end.stamp) paths_.find(m, start.kin, end.kin, end.way);
  paths_stamp_ = end.stamp;
  return paths_;
}

// How far points of the candidate's shapes stray from straight lines, as the static or the body of
// the other shape sees them. In a frame that turns at w, points at x with the velocity v have the
// acceleration -w x (w x x) - w' x x - 2 w x v besides; `chord`: no point gets farther there.
double GapCheck::bulge(const Model& m, const ContactCandidate& c, Poses& start, Poses& end,
                       double chord) {
  const PathBounds& p = paths(m, start, end);
  double most = p.acceleration(world_.shapes[c.shape]);
  if (c.other_shape < 0) return 0.125 * most;
  const CollisionShape& other = world_.shapes[c.other_shape];
  const int b = other.body;
  double away = 0;
  for (int i : {c.shape, c.other_shape})
    for (Poses* at : {&start, &end}) {
      const BoundingSphere& s = at->cached_bounding_sphere(world_.shapes, i);
      away = std::max(away, norm(s.center - at->kin.xpos[b]) + s.radius);
    }
  const double spin = p.spin(b), seen = p.acceleration(b, away);
  if (other.skin) most += p.acceleration(other) + seen;
  // v is at most the chord and half of the acceleration.
  return spin < 0.5 ? 0.125 * (most + seen + 2 * spin * chord) / (1 - spin) : 1e300;
}

// Does the vertex that ends deepest come nearer to a static than the swept hull may? The hull has it,
// so that it is not clear either. (A polygon stands for a disc.)
bool GapCheck::vertex_meets(const ContactCandidate& c, Poses& end) const {
  const PosedShape& a1 = world_.place(end, c.shape);
  if (c.other_static < 0 || a1.hull->rim > 0) return false;
  const Points p = a1.points();
  const Vec3 x = p.at(p.support(-c.n)) + c.shift();
  const Support point{{&x.x, &x.y, &x.z, 1}};
  const double least = a1.hull->radius + world_.settings.clearance;
  Vec3 pa, pb;
  if (c.triangle < 0) {
    const PosedShape& b = world_.statics[c.other_static].posed;
    return gjk(point, b.support(), c.n, pa, pb, least + b.hull->radius) <= least + b.hull->radius;
  }
  Vec3 v[3];
  world_.statics[c.other_static].tree->triangle(c.triangle, v);
  const TrianglePoints triangle(v);
  return gjk(point, triangle.support(), c.n, pa, pb, least) <= least;
}

bool GapCheck::swept_clear(const Model& m, const ContactCandidate& c, Poses& start, Poses& end) {
  if (c.dist < world_.settings.clearance || vertex_meets(c, end)) return false;
  const PosedShape &a0 = world_.place(start, c.shape), &a1 = world_.place(end, c.shape);
  Mat3 back;
  Vec3 shift;
  if (c.other_shape >= 0) {
    // Into the other's start frame: x -> R0 R1^T (x - p1) + p0.
    int b = world_.shapes[c.other_shape].body;
    back = start.kin.xmat[b] * transposed(end.kin.xmat[b]);
    shift = start.kin.xpos[b] - back * end.kin.xpos[b];
  }
  const SweptPoints swept = swept_points(a0, a1, c, back, shift);
  tests_ += 2 * tuning::geometry::kMeasureTests;
  double chord = c.other_shape >= 0 ? swept.farthest() : 0;
  double margin = a0.hull->radius + world_.settings.clearance;
  Vec3 pa, pb;
  if (c.other_static >= 0 && c.triangle >= 0) {
    Vec3 v[3];
    world_.statics[c.other_static].tree->triangle(c.triangle, v);
    const TrianglePoints triangle(v);
    margin += bulge(m, c, start, end, chord);
    return gjk(swept.support(), triangle.support(), c.n, pa, pb, margin) > margin;
  }
  const PosedShape& b = c.other_static >= 0 ? world_.statics[c.other_static].posed
                                            : world_.place(start, c.other_shape);
  margin += b.hull->radius;
  if (c.other_shape < 0 || !world_.shapes[c.other_shape].skin) {
    margin += bulge(m, c, start, end, chord);
    return gjk(swept.support(), b.support(), c.n, pa, pb, margin) > margin;
  }
  // A skin hull deforms as seen from the frame that carries it: both ends of it are in its swept
  // hull.
  const Points q0 = b.points(), q1 = world_.place(end, c.other_shape).points();
  SweptPoints other(q0.n);
  for (int i = 0; i < q0.n; i++)
    other.set(i, q0.at(i)), other.set(q0.n + i, back * q1.at(i) + shift);
  chord += other.farthest();
  margin += bulge(m, c, start, end, chord);
  return gjk(swept.support(), other.support(), c.n, pa, pb, margin) > margin;
}

bool GapCheck::mesh_clear(const Model& m, const ContactCandidate& c, Poses& start, Poses& end) {
  if (world_.shapes[c.shape].hull.rim > 0) return false;
  if (answers_stamp_ != end.stamp) answers_.clear(), answers_stamp_ = end.stamp;
  for (const MeshAnswer& w : answers_)
    if (w.shape == c.shape && w.other_static == c.other_static) return w.clear;
  const bool clear = swept_mesh_clear(m, c, start, end);
  answers_.push_back({c.shape, c.other_static, clear});
  return clear;
}

bool GapCheck::swept_mesh_clear(const Model& m, const ContactCandidate& c, Poses& start,
                                Poses& end) {
  const PosedShape &a0 = world_.place(start, c.shape), &a1 = world_.place(end, c.shape);
  static thread_local Convex hull;
  static thread_local PosedShape swept;
  const int n = a0.points().n;
  hull.vertices.resize(2 * (size_t)n);
  swept.hull = &hull;
  swept.xyz.resize(6 * (size_t)n);
  for (int k = 0; k < 3; k++)
    for (int i = 0; i < n; i++) {
      swept.xyz[(size_t)k * 2 * n + i] = a0.xyz[(size_t)k * n + i] + c.from[k];
      swept.xyz[(size_t)k * 2 * n + n + i] = a1.xyz[(size_t)k * n + i] + c.shift()[k];
    }
  swept.center = 0.5 * (a0.center + c.from + a1.center + c.shift());
  const Box3 &b0 = a0.box(), &b1 = a1.box();
  Box3 box;
  for (Vec3 p : {b0.lo + c.from, b0.hi + c.from, b1.lo + c.shift(), b1.hi + c.shift()}) box.add(p);
  swept.set_box(box);
  const double margin = 0.125 * paths(m, start, end).acceleration(world_.shapes[c.shape]) +
                        a0.hull->radius + world_.settings.clearance;
  return !world_.statics[c.other_static].tree->nearer(swept, margin, tests_);
}

double GapCheck::unforgiven(Poses& end, ContactCandidate& c) const {
  c.forgiven = false;
  return world_.place(end, c.shape).lowest(c.n) + dot(c.n, c.shift()) - c.offset - c.target;
}

double GapCheck::excess(const Model& m, Poses& start, Poses& end, ContactCandidate& c,
                        double slack) {
  const PosedShape& a1 = world_.place(end, c.shape);
  c.forgiven = false;
  double gap;
  if (c.other_static >= 0) {
    gap = a1.lowest(c.n) + dot(c.n, c.shift()) - c.offset;
    const bool half_space = world_.statics[c.other_static].kind == Static::Kind::HalfSpace;
    if (half_space || gap >= c.target - slack) return gap - c.target;
    if (overhang_.any(start, end, c)) {
      const Separation s = overhang_.at_end(start, end, c);
      if (s.dist > 0 && dot(s.n, c.n) > tune::kSameSide) return s.dist - c.target;
    }
  } else {
    const PosedShape& b1 = world_.place(end, c.other_shape);
    PosedShape moved;
    if (c.overlap >= 0) moved = displaced(a1, c.shift());
    const PosedShape& a = c.overlap >= 0 ? moved : a1;
    gap = separate_along(a, b1, c.n).dist;
    if (gap >= c.target - slack || c.dist < 0) return gap - c.target;
    Hint hint = c.hint;
    tests_ += tuning::geometry::kMeasureTests;
    Separation s = separate(a, b1, 1e300, false, c.n, &hint);
    if (s.dist > 0 && dot(s.n, c.n) > tune::kSameSide) return s.dist - c.target;
  }
  if (swept_clear(m, c, start, end)) {
    c.forgiven = true;
    return kForgiven;
  }
  return gap - c.target;
}

}  // namespace hp
