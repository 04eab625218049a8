#include "geometry/gjk.h"

#include "geometry/disc_distance.h"
#include "tuning.h"

namespace hp {

namespace tune = tuning::geometry;

namespace {

// The point of a simplex nearest to the origin: vertices that carry it, and their weights.
struct Nearest {
  Vec3 p;
  int n;
  int id[4];
  double l[4];
};

Nearest nearest_segment(const Vec3* w, int i, int j) {
  Vec3 d = w[j] - w[i];
  double t = -dot(w[i], d), dd = norm2(d);
  if (t <= 0 || dd == 0) return {w[i], 1, {i}, {1}};
  if (t >= dd) return {w[j], 1, {j}, {1}};
  t /= dd;
  return {w[i] + t * d, 2, {i, j}, {1 - t, t}};
}

Nearest nearest_triangle(const Vec3* w, int i, int j, int k) {
  Vec3 A = w[i], B = w[j], C = w[k], ab = B - A, ac = C - A;
  double d1 = -dot(ab, A), d2 = -dot(ac, A);
  if (d1 <= 0 && d2 <= 0) return {A, 1, {i}, {1}};
  double d3 = -dot(ab, B), d4 = -dot(ac, B);
  if (d3 >= 0 && d4 <= d3) return {B, 1, {j}, {1}};
  double vc = d1 * d4 - d3 * d2;
  if (vc <= 0 && d1 >= 0 && d3 <= 0) return nearest_segment(w, i, j);
  double d5 = -dot(ab, C), d6 = -dot(ac, C);
  if (d6 >= 0 && d5 <= d6) return {C, 1, {k}, {1}};
  double vb = d5 * d2 - d1 * d6;
  if (vb <= 0 && d2 >= 0 && d6 <= 0) return nearest_segment(w, i, k);
  double va = d3 * d6 - d5 * d4;
  if (va <= 0 && d4 - d3 >= 0 && d5 - d6 >= 0) return nearest_segment(w, j, k);
  Vec3 normal = cross(ab, ac);
  double nn = norm2(normal), s = 1 / (va + vb + vc);
  // Projection on the plane: more exact than the weighted sum of far vertices.
  Vec3 p = nn > 0 ? (dot(A, normal) / nn) * normal : A + (vb * s) * ab + (vc * s) * ac;
  return {p, 3, {i, j, k}, {va * s, vb * s, vc * s}};
}

// Where the origin is known to be outside, a flat tetrahedron cannot make rounding say otherwise.
Nearest nearest_tetrahedron(const Vec3* w, bool outside, bool& inside) {
  static const int face[4][4] = {{0, 1, 2, 3}, {0, 2, 3, 1}, {0, 3, 1, 2}, {1, 3, 2, 0}};
  Nearest best{};
  double least = 1e300;
  inside = true;
  auto look = [&](const int* f) {
    Nearest q = nearest_triangle(w, f[0], f[1], f[2]);
    double d = norm2(q.p);
    if (d < least) least = d, best = q;
  };
  for (const int* f : face) {
    Vec3 n = cross(w[f[1]] - w[f[0]], w[f[2]] - w[f[0]]);
    double other = dot(w[f[3]] - w[f[0]], n), origin = -dot(w[f[0]], n);
    if (other * origin >= 0 && other != 0) continue;
    inside = false;
    look(f);
  }
  if (inside && outside) {
    inside = false;
    for (const int* f : face) look(f);
  }
  return best;
}

// Points of A - B, and the points of A and B that they are differences of.
struct Simplex {
  Vec3 w[4], a[4], b[4];
  int in_a[4], in_b[4];  // their vertices
  int n = 0;

  void add(int i, int j, Vec3 p, Vec3 q) {
    a[n] = p, b[n] = q, w[n] = p - q;
    in_a[n] = i, in_b[n] = j;
    n++;
  }
  bool has(Vec3 p) const {
    bool known = false;
    for (int k = 0; k < n; k++) known |= norm2(p - w[k]) < tune::kSameSupport2;
    return known;
  }
  Nearest nearest(bool outside, bool& inside) const {
    return n == 1   ? Nearest{w[0], 1, {0}, {1}}
           : n == 2 ? nearest_segment(w, 0, 1)
           : n == 3 ? nearest_triangle(w, 0, 1, 2)
                    : nearest_tetrahedron(w, outside, inside);
  }
  // Keeps the vertices that carry a point, which is pa - pb.
  void reduce(const Nearest& near, Vec3& pa, Vec3& pb) {
    Simplex kept;
    kept.n = near.n;
    pa = pb = {};
    for (int k = 0; k < near.n; k++) {
      int id = near.id[k];
      kept.w[k] = w[id], kept.a[k] = a[id], kept.b[k] = b[id];
      kept.in_a[k] = in_a[id], kept.in_b[k] = in_b[id];
      pa += near.l[k] * a[id];
      pb += near.l[k] * b[id];
    }
    *this = kept;
  }
  // Vertices that were nearest before, but for the pair (i, j).
  void add_hint(const Hint& hint, const Points& a, const Points& b, int i, int j) {
    for (int k = 0; k < hint.n; k++)
      if (hint.a[k] != i || hint.b[k] != j)
        add(hint.a[k], hint.b[k], a.at(hint.a[k]), b.at(hint.b[k]));
  }
  void save(Hint& hint) const {
    hint.n = std::min(n, 3);
    std::copy_n(in_a, hint.n, hint.a);
    std::copy_n(in_b, hint.n, hint.b);
  }
};

// The pairs of vertices that carry a simplex of two shapes, of which one is swept by a disc: points of
// its rim that belong to one vertex count once.
Hint features(const Simplex& s) {
  Hint f;
  for (int k = 0; k < s.n && f.n < 3; k++) {
    bool known = false;
    for (int l = 0; l < f.n; l++) known |= f.a[l] == s.in_a[k] && f.b[l] == s.in_b[k];
    if (known) continue;
    f.a[f.n] = s.in_a[k], f.b[f.n++] = s.in_b[k];
  }
  return f;
}

// The distance of such features, as gjk() returns it, if no support point is nearer (disc_distance.h);
// else 0.
double distance_of(const Hint& f, const Support& a, const Support& b, double beyond, Vec3& pa,
                   Vec3& pb) {
  Vec3 m[3];
  for (int k = 0; k < f.n; k++) m[k] = a.points.at(f.a[k]) - b.points.at(f.b[k]);
  DiscDistance found;
  const Support& swept = a.rim > 0 ? a : b;
  if (!disc_distance(m, f.n, swept.axis, swept.rim, found)) return 0;
  const Vec3 v = found.x - found.d;
  const double vv = norm2(v), length = std::sqrt(vv);
  if (length < tune::kProvedApart) return 0;
  const Vec3 p = a.farthest(-v), q = b.farthest(v);
  if (vv - dot(v, p - q) > tune::kDiscProgress * vv + tune::kDiscRounding * length * norm(p))
    return 0;
  pa = a.rim > 0 ? -found.d : Vec3{};
  for (int k = 0; k < f.n; k++) pa += found.l[k] * a.points.at(f.a[k]);
  pb = pa - v;
  if (length > beyond) pa = (1 / length) * v, pb = {};
  return length;
}

}  // namespace

double gjk(const Support& a, const Support& b, Vec3 guess, Vec3& pa, Vec3& pb, double beyond,
           Hint* hint) {
  Simplex s;
  Vec3 v = norm2(guess) > 1e-24 ? guess : Vec3{1, 0, 0}, best;
  double vv = 1e300;
  double apart = 0;  // the distance that a separating direction has proved: `best`, a unit vector
  const bool disc = (a.rim > 0) != (b.rim > 0);
  if (disc && hint && hint->n > 0)
    if (const double known = distance_of(*hint, a, b, beyond, pa, pb); known > 0) return known;
  for (int it = 0; it < tune::kGjkIterations; it++) {
    const int i = a.points.support(-v), j = b.points.support(v);
    const Vec3 p = a.swept(i, -v), q = b.swept(j, v), w = p - q;
    double vw = dot(v, w), length = norm(v);
    if (vw > apart * length) {
      apart = vw / length;
      best = (1 / length) * v;
      if (apart > beyond) {
        pa = best, pb = {};
        return apart;
      }
    }
    if (s.n) {
      if (vv - vw <= tune::kGjkProgress * vv) break;  // no support point gets nearer
      if (s.has(w)) break;
    }
    // Hints help once the shapes are known to be apart: then a flat tetrahedron cannot say
    // otherwise.
    if (s.n == 0 && hint && !disc && apart > tune::kProvedApart)
      s.add_hint(*hint, a.points, b.points, i, j);
    s.add(i, j, p, q);
    bool inside = false;
    Nearest near = s.nearest(apart > tune::kProvedApart, inside);
    if (inside || norm2(near.p) < tune::kAtOrigin2) {
      if (apart > tune::kProvedApart) break;  // by rounding alone
      return 0;
    }
    if (apart > tune::kTouching && norm2(near.p) < apart * apart * (1 - 1e-9)) {
      // Nearer than can be: the plane of a thin triangle is tilted by rounding, its corners are
      // not.
      near.p = {};
      for (int k = 0; k < near.n; k++) near.p += near.l[k] * s.w[near.id[k]];
    }
    if (norm2(near.p) >= vv) break;  // rounding: no further progress
    s.reduce(near, pa, pb);
    if (disc && apart > tune::kProvedApart) {
      const Hint f = features(s);
      if (hint) *hint = f;
      if (const double known = distance_of(f, a, b, beyond, pa, pb); known > 0) return known;
    }
    v = near.p;
    vv = norm2(v);
  }
  if (hint && a.rim == 0 && b.rim == 0) s.save(*hint);
  double found = std::sqrt(vv);
  if (apart > tune::kProvedApart && apart < (1 - 1e-7) * found) v = apart * best, found = apart;
  pb = pa - v;  // exactly along v
  return found;
}

}  // namespace hp
