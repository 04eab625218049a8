// Small fixed-size algebra: vectors, unit quaternions (wxyz), 3x3 matrices (row-major).
#pragma once
#include <algorithm>
#include <cmath>

#include "math/elementary.h"
#include "tuning.h"

namespace hp {

struct Vec3 {
  double x = 0, y = 0, z = 0;
  double operator[](int i) const { return i == 0 ? x : i == 1 ? y : z; }
  double& operator[](int i) { return i == 0 ? x : i == 1 ? y : z; }
};

inline Vec3 operator+(Vec3 a, Vec3 b) { return {a.x + b.x, a.y + b.y, a.z + b.z}; }
inline Vec3 operator-(Vec3 a, Vec3 b) { return {a.x - b.x, a.y - b.y, a.z - b.z}; }
inline Vec3 operator-(Vec3 a) { return {-a.x, -a.y, -a.z}; }
inline Vec3 operator*(double s, Vec3 a) { return {s * a.x, s * a.y, s * a.z}; }
inline Vec3& operator+=(Vec3& a, Vec3 b) { return a = a + b; }
inline Vec3& operator-=(Vec3& a, Vec3 b) { return a = a - b; }
inline double dot(Vec3 a, Vec3 b) { return a.x * b.x + a.y * b.y + a.z * b.z; }
inline Vec3 cross(Vec3 a, Vec3 b) {
  return {a.y * b.z - a.z * b.y, a.z * b.x - a.x * b.z, a.x * b.y - a.y * b.x};
}
inline double norm2(Vec3 a) { return dot(a, a); }
inline double norm(Vec3 a) { return std::sqrt(dot(a, a)); }
// No longer than `limit`.
inline Vec3 capped(Vec3 v, double limit) {
  const double n = norm(v);
  return n > limit ? (limit / n) * v : v;
}
inline Vec3 load3(const double* p) { return {p[0], p[1], p[2]}; }
inline void store3(double* p, Vec3 a) { p[0] = a.x, p[1] = a.y, p[2] = a.z; }

struct Quat {
  double w = 1, x = 0, y = 0, z = 0;
};

inline Quat load4(const double* p) { return {p[0], p[1], p[2], p[3]}; }
inline void store4(double* p, Quat q) { p[0] = q.w, p[1] = q.x, p[2] = q.y, p[3] = q.z; }
inline Quat operator*(Quat a, Quat b) {
  return {
      a.w * b.w - a.x * b.x - a.y * b.y - a.z * b.z, a.w * b.x + a.x * b.w + a.y * b.z - a.z * b.y,
      a.w * b.y - a.x * b.z + a.y * b.w + a.z * b.x, a.w * b.z + a.x * b.y - a.y * b.x + a.z * b.w};
}
inline Quat conjugate(Quat q) { return {q.w, -q.x, -q.y, -q.z}; }
inline Quat normalized(Quat q) {
  double s = 1 / std::sqrt(q.w * q.w + q.x * q.x + q.y * q.y + q.z * q.z);
  return {s * q.w, s * q.x, s * q.y, s * q.z};
}

// Unit quaternion of an axis-angle vector.
inline Quat exp_quat(Vec3 r) {
  double half = 0.5 * norm(r);
  // sin(x)/x by its series near zero, where the quotient loses digits.
  double sine, cosine;
  elementary::sin_cos(half, sine, cosine);
  double s =
      half < tuning::dynamics::kSeriesHalfAngle ? 0.5 * (1 - half * half / 6) : 0.5 * sine / half;
  return {cosine, s * r.x, s * r.y, s * r.z};
}

// Axis-angle vector of a unit quaternion, the shortest arc.
inline Vec3 log_quat(Quat q) {
  Vec3 v{q.x, q.y, q.z};
  double n = norm(v),
         f = n < tuning::dynamics::kNoRotation ? 2.0 : 2 * elementary::atan2(n, std::fabs(q.w)) / n;
  return (q.w < 0 ? -f : f) * v;
}

struct Mat3 {
  double m[9] = {1, 0, 0, 0, 1, 0, 0, 0, 1};
  Vec3 col(int j) const { return {m[j], m[3 + j], m[6 + j]}; }
};

inline Vec3 operator*(const Mat3& a, Vec3 v) {
  return {a.m[0] * v.x + a.m[1] * v.y + a.m[2] * v.z, a.m[3] * v.x + a.m[4] * v.y + a.m[5] * v.z,
          a.m[6] * v.x + a.m[7] * v.y + a.m[8] * v.z};
}
// Transposed product: from the parent's frame into the child's.
inline Vec3 mul_t(const Mat3& a, Vec3 v) {
  return {a.m[0] * v.x + a.m[3] * v.y + a.m[6] * v.z, a.m[1] * v.x + a.m[4] * v.y + a.m[7] * v.z,
          a.m[2] * v.x + a.m[5] * v.y + a.m[8] * v.z};
}
inline Mat3 operator*(const Mat3& a, const Mat3& b) {
  Mat3 c;
  for (int i = 0; i < 3; i++)
    for (int j = 0; j < 3; j++)
      c.m[3 * i + j] =
          a.m[3 * i] * b.m[j] + a.m[3 * i + 1] * b.m[3 + j] + a.m[3 * i + 2] * b.m[6 + j];
  return c;
}
inline Mat3 transposed(const Mat3& a) {
  Mat3 t;
  for (int i = 0; i < 3; i++)
    for (int j = 0; j < 3; j++) t.m[3 * i + j] = a.m[3 * j + i];
  return t;
}
inline Mat3 to_matrix(Quat q) {
  double w = q.w, x = q.x, y = q.y, z = q.z;
  return {{1 - 2 * (y * y + z * z), 2 * (x * y - w * z), 2 * (x * z + w * y), 2 * (x * y + w * z),
           1 - 2 * (x * x + z * z), 2 * (y * z - w * x), 2 * (x * z - w * y), 2 * (y * z + w * x),
           1 - 2 * (x * x + y * y)}};
}
// Solves a x = b by Cramer's rule; `a` must be well away from singular.
inline Vec3 solve3(const Mat3& a, Vec3 b) {
  Vec3 c0 = a.col(0), c1 = a.col(1), c2 = a.col(2);
  double d = 1 / dot(c0, cross(c1, c2));
  return {d * dot(b, cross(c1, c2)), d * dot(c0, cross(b, c2)), d * dot(c0, cross(c1, b))};
}

// Two unit vectors that complete a unit normal to a right-handed frame (n, t, b).
inline void tangents(Vec3 n, Vec3& t, Vec3& b) {
  t = std::fabs(n.x) < 0.7 ? Vec3{0, n.z, -n.y} : Vec3{-n.z, 0, n.x};
  t = (1 / norm(t)) * t;
  b = cross(n, t);
}

struct Box3 {
  Vec3 lo{1e300, 1e300, 1e300}, hi{-1e300, -1e300, -1e300};
  void add(Vec3 p) {
    lo = {std::min(lo.x, p.x), std::min(lo.y, p.y), std::min(lo.z, p.z)};
    hi = {std::max(hi.x, p.x), std::max(hi.y, p.y), std::max(hi.z, p.z)};
  }
  void grow(double r) { lo -= Vec3{r, r, r}, hi += Vec3{r, r, r}; }
  // Largest n.x over the box.
  double highest(Vec3 n) const {
    return (n.x > 0 ? hi.x : lo.x) * n.x + (n.y > 0 ? hi.y : lo.y) * n.y +
           (n.z > 0 ? hi.z : lo.z) * n.z;
  }
  bool meets(const Box3& o) const {
    return lo.x <= o.hi.x && o.lo.x <= hi.x && lo.y <= o.hi.y && o.lo.y <= hi.y && lo.z <= o.hi.z &&
           o.lo.z <= hi.z;
  }
};

}  // namespace hp
