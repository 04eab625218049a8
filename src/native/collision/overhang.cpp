#include "collision/overhang.h"

#include <algorithm>
#include <cmath>

#include "geometry/contact_manifold.h"
#include "tuning.h"

namespace hp {

namespace tune = tuning::collision;

namespace {

// Something that does not move, as a shape: a point or a triangle.
struct Fixed {
  Convex hull;
  PosedShape posed;
  explicit Fixed(Vec3 x) { place({x}); }
  explicit Fixed(const Vec3 v[3]) {
    const Vec3 n = cross(v[1] - v[0], v[2] - v[0]);
    const double size = norm(n);
    if (size > 0) hull.normals = {(1 / size) * n, (-1 / size) * n};
    place({v[0], v[1], v[2]});
  }

 private:
  void place(std::vector<Vec3> vertices) {
    hull.vertices = std::move(vertices);
    hull.finish();
    posed.place(hull, {}, {});
  }
};

// No point of a rigid shape goes farther between two poses.
double way(const PosedShape& a0, const PosedShape& a1) {
  double turn2 = 0;
  for (int i = 0; i < 9; i++) turn2 += (a1.R.m[i] - a0.R.m[i]) * (a1.R.m[i] - a0.R.m[i]);
  return norm(a1.center - a0.center) + a0.hull->bound * std::sqrt(turn2);
}

// Calls f(point of the unrounded shape, where it was at the start, its vertex) for its vertices, of
// discs for points of their rims (vertex -1): the deepest ones along -n, and around those that lie flat.
template <typename F>
bool any_point(const PosedShape& a0, const PosedShape& a1, Vec3 n, F f) {
  const Support s0 = a0.support(), s1 = a1.support();
  if (s1.rim == 0) {
    for (int v = 0; v < s1.points.n; v++)
      if (f(s1.points.at(v), s0.points.at(v), v)) return true;
    return false;
  }
  Vec3 t, b;
  tangents(n, t, b);
  for (int v = 0; v < s1.points.n; v++) {
    if (f(s1.points.at(v) + s1.on_rim(-n), s0.points.at(v) + s0.on_rim(-n), -1)) return true;
    for (int k = 0; k < tune::kRimLooks; k++) {
      const double angle = 2 * M_PI * k / tune::kRimLooks;
      const Vec3 d = elementary::cos(angle) * t + elementary::sin(angle) * b;
      if (f(s1.points.at(v) + s1.on_rim(d), s0.points.at(v) + s0.on_rim(d), -1)) return true;
    }
  }
  return false;
}

// The farthest corners along evenly turned directions across a normal. Those of the sides below a face
// project to its edge too: a corner must be farther out by a multiple of what its gap is larger by.
struct Extremes {
  static constexpr int kMost = Overhang::kMostCorners;
  Vec3 directions[kMost], pa[kMost], pb[kMost];
  double reach[kMost];

  explicit Extremes(Vec3 n) {
    Vec3 t, s;
    tangents(n, t, s);
    for (int k = 0; k < kMost; k++) {
      const double angle = 2 * M_PI * (k + 0.125) / kMost;
      directions[k] = elementary::cos(angle) * t + elementary::sin(angle) * s;
      reach[k] = -1e300;
    }
  }
  bool beyond(Vec3 x) const {
    for (int k = 0; k < kMost; k++)
      if (dot(directions[k], x) > reach[k]) return true;
    return false;
  }
  void add(Vec3 a, Vec3 b, double deeper) {
    for (int k = 0; k < kMost; k++) {
      const double far = dot(directions[k], b) - tune::kFartherThanDeeper * deeper;
      if (far > reach[k]) reach[k] = far, pa[k] = a, pb[k] = b;
    }
  }
  int take(Vec3* out_a, Vec3* out_b) const {
    int n = 0;
    for (int k = 0; k < kMost; k++) {
      bool known = reach[k] == -1e300;
      for (int i = 0; i < n; i++) known |= norm2(out_b[i] - pb[k]) < tune::kSamePoint2;
      if (!known) out_a[n] = pa[k], out_b[n++] = pb[k];
    }
    return n;
  }
};

}  // namespace

bool Overhang::any(Poses& start, Poses& end, const ContactCandidate& c) {
  if (c.other_static < 0 || c.overlap >= 0 || c.dist < 0) return false;
  if (world_.shapes[c.shape].person >= 0) return false;
  if (world_.statics[c.other_static].kind == Static::Kind::HalfSpace) return false;
  const PosedShape &a0 = world_.place(start, c.shape), &a1 = world_.place(end, c.shape);
  const double radius = a1.hull->radius;
  std::vector<Known>* vertices =
      radius == 0 && a1.hull->rim == 0 ? &known(c, start, a0.points().n) : nullptr;
  return any_point(a0, a1, c.n, [&](Vec3 at_end, Vec3 at_start, int v) {
    if (dot(c.n, at_end) - radius - c.offset >= c.target) return false;
    return !(vertices ? over(c, at_start, (*vertices)[v]) : over(c, at_start - radius * c.n));
  });
}

std::vector<Overhang::Known>& Overhang::known(const ContactCandidate& c, const Poses& start,
                                              size_t vertices) {
  if (known_stamp_ != start.stamp) known_.clear(), known_stamp_ = start.stamp;
  for (StartDistances& k : known_)
    if (k.shape == c.shape && k.other_static == c.other_static) return k.vertices;
  known_.push_back({c.shape, c.other_static, std::vector<Known>(vertices)});
  return known_.back().vertices;
}

// Above the candidate's plane, and a little more.
double Overhang::height(const ContactCandidate& c, Vec3 x) const {
  return std::max(dot(c.n, x) - c.offset, 0.0) + tune::kOver;
}

bool Overhang::over(const ContactCandidate& c, Vec3 x) { return within(c, x, height(c, x)); }

bool Overhang::over(const ContactCandidate& c, Vec3 x, Known& known) {
  const double gap = height(c, x);
  if (gap > known.farther && gap < known.nearest)
    (within(c, x, gap) ? known.nearest : known.farther) = gap;
  return gap >= known.nearest;
}

// Is a point no farther from the static than this?
bool Overhang::within(const ContactCandidate& c, Vec3 x, double distance) {
  const Fixed point(x);
  const Static& S = world_.statics[c.other_static];
  if (S.kind == Static::Kind::Mesh) return S.tree->nearer(point.posed, distance, tests_);
  tests_ += tuning::geometry::kMeasureTests;
  return separate(point.posed, S.posed, distance, false, c.n).dist <= distance;
}

Separation Overhang::at_end(Poses& start, Poses& end, const ContactCandidate& c) {
  const Static& S = world_.statics[c.other_static];
  if (S.kind == Static::Kind::Hull) {
    tests_ += tuning::geometry::kMeasureTests;
    return separate(world_.place(end, c.shape), S.posed, 1e300, false, c.n);
  }
  const EndDistance& e = from_mesh(start, end, c);
  return e.nearest.dist < e.range ? e.nearest : Separation{e.range, c.n, {}, {}};
}

const Overhang::EndDistance& Overhang::from_mesh(Poses& start, Poses& end,
                                                 const ContactCandidate& c) {
  if (ends_stamp_ != end.stamp) ends_.clear(), ends_stamp_ = end.stamp;
  for (const EndDistance& e : ends_)
    if (e.shape == c.shape && e.other_static == c.other_static) return e;
  const PosedShape &a0 = world_.place(start, c.shape), &a1 = world_.place(end, c.shape);
  const TriangleTree& tree = *world_.statics[c.other_static].tree;
  EndDistance e{
      c.shape, c.other_static, world_.settings.clearance + way(a0, a1), {1e300, {}, {}, {}}};
  Plane plane;
  if (tree.nearest(a1, e.range, plane, tests_)) {
    Vec3 v[3];
    tree.triangle(plane.triangle, v);
    e.nearest = separate(a1, Fixed(v).posed, 1e300, false, plane.n);
  }
  ends_.push_back(e);
  return ends_.back();
}

int Overhang::corners(Poses& start, const ContactCandidate& c, Vec3* pa, Vec3* pb) {
  const PosedShape& a0 = world_.place(start, c.shape);
  const Static& S = world_.statics[c.other_static];
  if (S.kind == Static::Kind::Hull)
    return face_manifold(a0, S.posed, c.n, tune::kFaceThickness, kMostCorners, pa, pb);
  Box3 box = a0.box();
  box.grow(c.dist + tune::kFaceThickness);
  Extremes extremes(c.n);
  for (int t : S.tree->meeting(box)) {
    Vec3 v[3];
    S.tree->triangle(t, v);
    bool near = false, wider = false;
    for (Vec3 x : v)
      near |= dot(c.n, x) > c.offset - tune::kFaceThickness, wider |= extremes.beyond(x);
    if (!near || !wider) continue;
    tests_ += tuning::geometry::kMeasureTests;
    const Fixed triangle(v);
    Vec3 qa[kMostCorners], qb[kMostCorners];
    const int n =
        face_manifold(a0, triangle.posed, c.n, tune::kFaceThickness, kMostCorners, qa, qb);
    for (int i = 0; i < n; i++) {
      const double deeper = dot(c.n, qa[i] - qb[i]) - c.dist;
      if (deeper < tune::kFaceThickness) extremes.add(qa[i], qb[i], std::max(0.0, deeper));
    }
  }
  return extremes.take(pa, pb);
}

}  // namespace hp
