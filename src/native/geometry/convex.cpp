#include "geometry/convex.h"

#include "math/simd.h"

namespace hp {

namespace {

constexpr double kClose = 2e-3;         // [m]
constexpr double kTouching = 1e-5;      // [m]
constexpr double kSeparates = 1e-6;     // [m]
constexpr double kSameDistance = 1e-7;  // [m]
constexpr double kProved = 1e-9;        // [m]

}  // namespace

int Points::support(Vec3 d) const { return farthest(x, y, z, n, d.x, d.y, d.z); }

void Convex::lay_out() {
  Box3 box;
  for (Vec3 v : vertices) box.add(v);
  center = 0.5 * (box.lo + box.hi);
  xyz.clear();
  for (int k = 0; k < 3; k++)
    for (Vec3 v : vertices) xyz.push_back(v[k]);
}

void Convex::finish() {
  lay_out();
  bound = 0;
  for (Vec3 v : vertices) {
    double along = dot(axis, v - center), across = norm(v - center - along * axis);
    bound = std::max(bound, std::hypot(along, across + rim));
  }
  bound += radius;
}

void PosedShape::place(const Convex& c, const Mat3& rot, Vec3 pos) {
  hull = &c;
  R = rot;
  center = pos + rot * c.center;
  int n = (int)c.vertices.size();
  xyz.resize(3 * n);
  double at[3], lo[3], hi[3];
  store3(at, pos);
  transform(c.xyz.data(), n, rot.m, at, xyz.data(), lo, hi);
  box = {load3(lo), load3(hi)};
  box.grow(c.radius);
  axis = rot * c.axis;
  if (c.rim == 0) return;
  Vec3 side;
  for (int k = 0; k < 3; k++) side[k] = c.rim * std::sqrt(std::max(0.0, 1 - axis[k] * axis[k]));
  box.lo -= side;
  box.hi += side;
}

PosedShape displaced(const PosedShape& a, Vec3 shift) {
  PosedShape b(a);
  if (norm2(shift) == 0) return b;
  const size_t n = a.hull->vertices.size();
  for (size_t k = 0; k < 3; k++)
    for (size_t i = 0; i < n; i++) b.xyz[k * n + i] += shift[(int)k];
  b.center += shift;
  b.box.lo += shift, b.box.hi += shift;
  return b;
}

double PosedShape::lowest(Vec3 n) const {
  Points p = points();
  return dot(n, p.at(p.support(-n))) - reach(n);
}

namespace {

struct Simplex {
  Vec3 w[4], a[4], b[4];
  int in_a[4], in_b[4];  // their vertices
  int n = 0;
  void add(int i, int j, Vec3 p, Vec3 q) {
    a[n] = p, b[n] = q, w[n] = p - q;
    in_a[n] = i, in_b[n] = j;
    n++;
  }
};

// Nearest point to the origin of a segment, triangle or tetrahedron (Ericson 2005, ch. 5); keeps
// the vertices that carry it and their weights.
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

}  // namespace

double gjk(const Support& a, const Support& b, Vec3 guess, Vec3& pa, Vec3& pb, double beyond,
           Hint* hint) {
  Simplex s;
  Vec3 v = norm2(guess) > 1e-24 ? guess : Vec3{1, 0, 0}, best;
  double vv = 1e300;
  double apart = 0;  // the distance that a separating direction has proved: `best`, a unit vector
  for (int it = 0; it < 64; it++) {
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
      if (vv - vw <= 1e-13 * vv) break;  // no support point gets nearer
      bool known = false;
      for (int k = 0; k < s.n; k++) known |= norm2(w - s.w[k]) < 1e-28;
      if (known) break;
    }
    // Corners that were nearest before are at hand once the two are known to be apart: a flat
    // tetrahedron of them cannot say otherwise.
    if (s.n == 0 && hint && apart > kProved)
      for (int k = 0; k < hint->n; k++)
        if (hint->a[k] != i || hint->b[k] != j)
          s.add(hint->a[k], hint->b[k], a.points.at(hint->a[k]), b.points.at(hint->b[k]));
    s.add(i, j, p, q);
    bool inside = false;
    Nearest near = s.n == 1   ? Nearest{s.w[0], 1, {0}, {1}}
                   : s.n == 2 ? nearest_segment(s.w, 0, 1)
                   : s.n == 3 ? nearest_triangle(s.w, 0, 1, 2)
                              : nearest_tetrahedron(s.w, apart > kProved, inside);
    if (inside || norm2(near.p) < 1e-22) {
      if (apart > kProved) break;  // by rounding alone
      return 0;
    }
    if (apart > kTouching && norm2(near.p) < apart * apart * (1 - 1e-9)) {
      // Nearer than can be: the plane of a thin triangle is tilted by rounding, its corners not.
      near.p = {};
      for (int k = 0; k < near.n; k++) near.p += near.l[k] * s.w[near.id[k]];
    }
    if (norm2(near.p) >= vv) break;  // rounding: no further progress
    Simplex kept;
    kept.n = near.n;
    pa = pb = {};
    for (int k = 0; k < near.n; k++) {
      int id = near.id[k];
      kept.w[k] = s.w[id], kept.a[k] = s.a[id], kept.b[k] = s.b[id];
      kept.in_a[k] = s.in_a[id], kept.in_b[k] = s.in_b[id];
      pa += near.l[k] * s.a[id];
      pb += near.l[k] * s.b[id];
    }
    s = kept;
    v = near.p;
    vv = norm2(v);
  }
  if (hint && a.rim == 0 && b.rim == 0) {
    hint->n = std::min(s.n, 3);
    std::copy_n(s.in_a, hint->n, hint->a);
    std::copy_n(s.in_b, hint->n, hint->b);
  }
  double found = std::sqrt(vv);
  if (apart > kProved && apart < (1 - 1e-7) * found) v = apart * best, found = apart;
  pb = pa - v;  // exactly along v
  return found;
}

Separation separate_along(const PosedShape& a, const PosedShape& b, Vec3 n) {
  Vec3 pa = a.support().farthest(-n) - a.hull->radius * n;
  double dist = dot(n, pa) - b.highest(n);
  return {dist, n, pa, pa - dist * n};
}

Separation separate(const PosedShape& a, const PosedShape& b, double beyond, bool way_out, Vec3 guess,
                    Hint* hint) {
  double round = a.hull->radius + b.hull->radius;
  Vec3 pa, pb;
  if (norm2(guess) == 0) guess = a.center - b.center;
  double d = gjk(a.support(), b.support(), guess, pa, pb, beyond + round, hint);
  if (d > beyond + round) return {d - round, pa - pb, {}, {}};
  Separation best;
  best.dist = -1e300;
  auto consider = [&](Vec3 n) {
    Separation s = separate_along(a, b, n);
    if (s.dist > best.dist) best = s;
  };
  if (d > 1e-9) {
    Vec3 n = (1 / d) * (pa - pb);
    Separation found{d - round, n, pa - a.hull->radius * n, pb + b.hull->radius * n};
    if (d > kClose && a.hull->rim == 0 && b.hull->rim == 0) return found;
    // So near (and between flat ends of round things even farther off) rounding tilts the line
    // between the nearest points. A face normal that separates as well is the direction that was
    // meant; friction on a tilted one would creep.
    double like = d < kTouching ? 0.9 : 0.9999;
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
    if (best.dist >= found.dist - kSameDistance) {
      found.n = best.n;
      found.dist = best.dist;
      return found;
    }
    // A line of rounding's length may point anywhere: only one that separates counts.
    consider(n);
    if (d > kTouching || best.dist >= found.dist - kSeparates) return found;
  }
  if (!way_out) return {-1e300, {}, {}, {}};
  for (Vec3 n : a.hull->normals) consider(-(a.R * n));
  for (Vec3 n : b.hull->normals) consider(b.R * n);
  Vec3 line = a.center - b.center;
  double length = norm(line);
  consider(length > 1e-9 ? (1 / length) * line : Vec3{0, 0, 1});
  auto either = [&](Vec3 n) {
    double size = norm(n);
    if (size < 1e-9) return;
    consider((1 / size) * n);
    consider((-1 / size) * n);
  };
  for (const PosedShape* c : {&a, &b})
    if (c->hull->rim > 0) either(line - dot(line, c->axis) * c->axis);
  if (a.hull->rim > 0 && b.hull->rim > 0) either(cross(a.axis, b.axis));
  return best;
}

namespace {

struct P2 {
  double u, v, height;
};

double cross2(P2 o, P2 a, P2 b) { return (a.u - o.u) * (b.v - o.v) - (a.v - o.v) * (b.u - o.u); }

// Vertices within tol of the face nearest along -n, projected on the plane, as a convex polygon
// in counter-clockwise order (monotone chain). A disc that is wholly that near gives eight points
// of its rim, another its nearest point alone: a round side is no face.
std::vector<P2> near_face(const PosedShape& s, Vec3 n, Vec3 t, Vec3 b, double tol) {
  Points p = s.points();
  Support swept = s.support();
  double low = dot(n, p.at(p.support(-n)));
  std::vector<P2> pts;
  auto add = [&](Vec3 x) { pts.push_back({dot(t, x), dot(b, x), dot(n, x)}); };
  for (int i = 0; i < p.n; i++) {
    Vec3 x = p.at(i);
    if (dot(n, x) > low + tol) continue;
    if (swept.rim == 0) {
      add(x);
    } else if (2 * (s.reach(n) - s.hull->radius) > tol) {
      add(x + swept.on_rim(-n));
    } else {
      for (int k = 0; k < 8; k++)
        add(x + swept.on_rim(std::cos(0.25 * M_PI * k) * t + std::sin(0.25 * M_PI * k) * b));
    }
  }
  std::sort(pts.begin(), pts.end(),
            [](P2 x, P2 y) { return x.u < y.u || (x.u == y.u && x.v < y.v); });
  if (pts.size() < 3) return pts;
  std::vector<P2> hull(2 * pts.size());
  size_t k = 0;
  for (size_t i = 0; i < pts.size(); hull[k++] = pts[i++])
    while (k >= 2 && cross2(hull[k - 2], hull[k - 1], pts[i]) <= 1e-12) k--;
  for (size_t i = pts.size() - 1, floor = k + 1; i-- > 0; hull[k++] = pts[i])
    while (k >= floor && cross2(hull[k - 2], hull[k - 1], pts[i]) <= 1e-12) k--;
  hull.resize(k - 1);
  return hull;
}

}  // namespace

namespace {

// Height of a near face at a point: of the plane through its widest three corners, or of an edge.
double height_at(const std::vector<P2>& face, P2 q) {
  const P2 &o = face[0], &e = face[1];
  if (face.size() == 2) {
    double u = e.u - o.u, v = e.v - o.v, along = (q.u - o.u) * u + (q.v - o.v) * v;
    return o.height + along / (u * u + v * v) * (e.height - o.height);
  }
  size_t i = 1, j = 2;
  double widest = 0;
  for (size_t k = 1; k < face.size(); k++)
    for (size_t l = k + 1; l < face.size(); l++) {
      double area = cross2(o, face[k], face[l]);
      if (area > widest) widest = area, i = k, j = l;
    }
  double f = cross2(o, q, face[j]) / widest, g = cross2(o, face[i], q) / widest;
  return o.height + f * (face[i].height - o.height) + g * (face[j].height - o.height);
}

}  // namespace

int face_manifold(const PosedShape& a, const PosedShape& b, Vec3 n, double tol, int most, Vec3* pa,
                  Vec3* pb) {
  Vec3 t, s;
  tangents(n, t, s);
  std::vector<P2> A = near_face(a, n, t, s, tol), B = near_face(b, -n, t, s, tol);
  if (A.size() < 2 || B.size() < 2 || (A.size() == 2 && B.size() == 2)) return 0;
  const std::vector<P2> face_a = A, face_b = B;
  if (B.size() == 2) std::swap(A, B);
  // Clip A (a segment or polygon) by the edges of the polygon B (Sutherland, Hodgman 1974).
  for (size_t e = 0; e < B.size() && !A.empty(); e++) {
    P2 p = B[e], q = B[(e + 1) % B.size()];
    std::vector<P2> out;
    for (size_t i = 0; i < A.size(); i++) {
      P2 c = A[i], d = A[(i + 1) % A.size()];
      double fc = cross2(p, q, c), fd = cross2(p, q, d);
      if (fc >= 0) out.push_back(c);
      if ((fc < 0) != (fd < 0)) {
        double f = fc / (fc - fd);
        out.push_back({c.u + f * (d.u - c.u), c.v + f * (d.v - c.v), 0});
      }
    }
    A = out;
  }
  if (A.empty()) return 0;
  // Spread: the extreme points along evenly turned directions.
  std::vector<P2> pick;
  for (int k = 0; k < most; k++) {
    double angle = 2 * M_PI * (k + 0.125) / most, cu = std::cos(angle), cv = std::sin(angle);
    P2 best = A[0];
    for (P2 q : A)
      if (cu * q.u + cv * q.v > cu * best.u + cv * best.v) best = q;
    bool known = false;
    for (P2 q : pick) known |= std::hypot(q.u - best.u, q.v - best.v) < 1e-9;
    if (!known) pick.push_back(best);
  }
  for (size_t k = 0; k < pick.size(); k++) {
    Vec3 base = pick[k].u * t + pick[k].v * s;
    pa[k] = base + (height_at(face_a, pick[k]) - a.hull->radius) * n;
    pb[k] = base + (b.hull->radius - height_at(face_b, pick[k])) * n;  // of -n
  }
  return (int)pick.size();
}

}  // namespace hp
