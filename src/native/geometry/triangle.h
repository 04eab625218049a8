// One triangle and one point: the closest point of the triangle (Ericson 2005, "Real-Time Collision
// Detection", 5.1.5) and the solid angle under which it is seen (Van Oosterom and Strackee 1983,
// "The solid angle of a plane triangle").
#pragma once

#include <algorithm>
#include <cmath>

namespace triangles {

struct Vec {
  double x, y, z;
};
inline Vec operator+(Vec a, Vec b) { return {a.x + b.x, a.y + b.y, a.z + b.z}; }
inline Vec operator-(Vec a, Vec b) { return {a.x - b.x, a.y - b.y, a.z - b.z}; }
inline Vec operator*(double s, Vec a) { return {s * a.x, s * a.y, s * a.z}; }
inline double dot(Vec a, Vec b) { return a.x * b.x + a.y * b.y + a.z * b.z; }
inline Vec cross(Vec a, Vec b) {
  return {a.y * b.z - a.z * b.y, a.z * b.x - a.x * b.z, a.x * b.y - a.y * b.x};
}
inline double norm(Vec a) { return std::sqrt(dot(a, a)); }

inline double axis(Vec v, int k) { return k == 0 ? v.x : (k == 1 ? v.y : v.z); }

struct Triangle {
  Vec a, b, c;
  int face;     // index in the caller's list
  bool sliver;  // no usable normal: its closest point is sought on its edges
};

// Half the solid angle of a triangle seen from the origin (Van Oosterom and Strackee 1983).
inline double half_solid_angle(Vec a, Vec b, Vec c) {
  const double la = norm(a), lb = norm(b), lc = norm(c);
  const double volume = dot(a, cross(b, c));
  const double scale = la * lb * lc + dot(a, b) * lc + dot(b, c) * la + dot(c, a) * lb;
  return std::atan2(volume, scale);
}

inline Vec closest_on_segment(Vec p, Vec a, Vec b) {
  const Vec ab = b - a;
  const double length2 = dot(ab, ab);
  if (!(length2 > 0.0)) return a;
  return a + std::clamp(dot(p - a, ab) / length2, 0.0, 1.0) * ab;
}

inline Vec closest_on_edges(Vec p, const Triangle& t) {
  const Vec candidates[3] = {closest_on_segment(p, t.a, t.b), closest_on_segment(p, t.b, t.c),
                             closest_on_segment(p, t.c, t.a)};
  Vec best = candidates[0];
  for (const Vec& q : candidates)
    if (dot(p - q, p - q) < dot(p - best, p - best)) best = q;
  return best;
}

// Closest point of a triangle by the region of the plane that p lies over (Voronoi regions).
inline Vec closest_on_triangle(Vec p, const Triangle& t) {
  if (t.sliver) return closest_on_edges(p, t);
  const Vec ab = t.b - t.a, ac = t.c - t.a, ap = p - t.a;
  const double d1 = dot(ab, ap), d2 = dot(ac, ap);
  if (d1 <= 0.0 && d2 <= 0.0) return t.a;
  const Vec bp = p - t.b;
  const double d3 = dot(ab, bp), d4 = dot(ac, bp);
  if (d3 >= 0.0 && d4 <= d3) return t.b;
  const double vc = d1 * d4 - d3 * d2;
  if (vc <= 0.0 && d1 >= 0.0 && d3 <= 0.0) return t.a + (d1 / (d1 - d3)) * ab;
  const Vec cp = p - t.c;
  const double d5 = dot(ab, cp), d6 = dot(ac, cp);
  if (d6 >= 0.0 && d5 <= d6) return t.c;
  const double vb = d5 * d2 - d1 * d6;
  if (vb <= 0.0 && d2 >= 0.0 && d6 <= 0.0) return t.a + (d2 / (d2 - d6)) * ac;
  const double va = d3 * d6 - d5 * d4;
  if (va <= 0.0 && d4 - d3 >= 0.0 && d5 - d6 >= 0.0)
    return t.b + ((d4 - d3) / ((d4 - d3) + (d5 - d6))) * (t.c - t.b);
  const double sum = va + vb + vc;
  return t.a + (vb / sum) * ab + (vc / sum) * ac;
}

}  // namespace triangles
