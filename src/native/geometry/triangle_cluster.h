// The winding number of a cluster of far triangles, by the Taylor expansion of its solid angle to
// second order (Barill et al. 2018, "Fast winding numbers for soups and clouds"), with a strict
// bound of what the expansion leaves out.
#pragma once

#include <cmath>

#include "geometry/triangle_slab.h"

namespace triangles {

constexpr double kFourPi = 12.566370614359172954;

// With G(r) = r / (4 pi |r|^3), the winding number is the integral of n . G(x - q) dA; around the
// cluster's centre p it is dipole . G(p - q) + tensor : DG(p - q) + rest, and |rest| <= 3/(4 pi) *
// second moment / d^4 where d is the distance of q from a convex shape that has all of them in it,
// as |D^2 G| <= 6/(4 pi d^4).
struct Cluster {
  Vec centre;
  double remainder;
  double change[2];    // over d^3 and d^4: bounds of how fast the expansion changes as q moves
  Vec dipole;          // integral of n dA, over 4 pi
  double diagonal[3];  // integral of (x - p)_i n_i dA, over 4 pi
  double mixed[3];     // xy, yz, zx: integral of (x - p)_i n_j + (x - p)_j n_i dA, over 4 pi
};

// The expansion, r from q to the centre; 1 / |r|^2 and 1 / |r|^3.
inline double far_field(const Cluster& c, Vec r, double inv2, double inv3) {
  const double trace = c.diagonal[0] + c.diagonal[1] + c.diagonal[2];
  const double quadratic = c.diagonal[0] * r.x * r.x + c.diagonal[1] * r.y * r.y +
                           c.diagonal[2] * r.z * r.z + c.mixed[0] * r.x * r.y +
                           c.mixed[1] * r.y * r.z + c.mixed[2] * r.z * r.x;
  return (dot(c.dipole, r) + trace - 3.0 * quadratic * inv2) * inv3;
}

// The cluster of some triangles in a box.
inline Cluster describe(const Triangle* triangles, int count, const Box& box) {
  Cluster c{};
  double area = 0.0;
  Vec centre{0, 0, 0};
  for (int i = 0; i < count; ++i) {
    const Triangle& t = triangles[i];
    const double twice = norm(cross(t.b - t.a, t.c - t.a));
    area += twice;
    centre = centre + twice / 3.0 * (t.a + t.b + t.c);
  }
  c.centre = area > 0.0 ? (1.0 / area) * centre : 0.5 * (box.lo + box.hi);
  double moment = 0.0;
  double m[3][3] = {};
  for (int i = 0; i < count; ++i) {
    const Triangle& t = triangles[i];
    const Vec a = t.a - c.centre, b = t.b - c.centre, d = t.c - c.centre;
    const Vec sum = a + b + d, n = 0.5 * cross(b - a, d - a);
    c.dipole = c.dipole + n;
    for (int r = 0; r < 3; ++r)
      for (int s = 0; s < 3; ++s) m[r][s] += axis(sum, r) / 3.0 * axis(n, s);
    moment += norm(n) / 12.0 * (dot(a, a) + dot(b, b) + dot(d, d) + dot(sum, sum));
  }
  c.dipole = (1.0 / kFourPi) * c.dipole;
  for (int r = 0; r < 3; ++r) {
    c.diagonal[r] = m[r][r] / kFourPi;
    c.mixed[r] = (m[r][(r + 1) % 3] + m[(r + 1) % 3][r]) / kFourPi;
  }
  c.remainder = 3.0 / kFourPi * moment;
  // |DG| <= 2 / (4 pi d^3), |D^2 G| <= 6 / (4 pi d^4).
  double square = 0.0;
  for (int r = 0; r < 3; ++r)
    square += c.diagonal[r] * c.diagonal[r] + 0.5 * c.mixed[r] * c.mixed[r];
  c.change[0] = 2.0 * norm(c.dipole);
  c.change[1] = 6.0 * std::sqrt(square);
  return c;
}

}  // namespace triangles
