#include "coulomb.h"

namespace hp {

void LocalContact::set(const Mat3& a, double friction) {
  A = a;
  mu = friction;
  for (int q = 0; q < 3; q++) {
    Vec3 e;
    e[q] = 1;
    Vec3 x = solve3(A, e);
    for (int l = 0; l < 3; l++) inverse.m[3 * l + q] = x[l];
  }
  double b = A.m[4], c = A.m[8], d = A.m[5];
  tangent_step = 1 / (0.5 * (b + c) + std::sqrt(0.25 * (b - c) * (b - c) + d * d));
}

double LocalContact::squared_residual(const double* p, const double* w) const {
  double e = std::min(w[0], p[0] * A.m[0]), sum = e * e;
  if (p[0] <= 0) return sum;
  double k = tangent_step, y = p[1] - k * w[1], z = p[2] - k * w[2],
         length = std::sqrt(y * y + z * z), limit = mu * p[0],
         f = length > limit ? limit / length : 1, ey = (f * y - p[1]) / k, ez = (f * z - p[2]) / k;
  return sum + ey * ey + ez * ez;
}

double LocalContact::residual(const double* p, const double* w) const {
  double normal = normal_residual(p, w), both = squared_residual(p, w);
  return std::max(normal, std::sqrt(std::max(0.0, both - normal * normal)));
}

// Sliding with p = p_n (1, mu c, mu s): p_n = -r_n / N from w_n = 0, and the slip times N is
// N r_t - r_n (A_tn + mu A_tt d), which must be parallel to d = (c, s) and point against it.
LocalContact::Slip LocalContact::slip(Vec3 r, double c, double s) const {
  const double* a = A.m;
  double n = a[0] + mu * (a[1] * c + a[2] * s), dn = mu * (-a[1] * s + a[2] * c);
  double x = c * r.z - s * r.y, dx = -s * r.z - c * r.y;
  double t1 = a[3] + mu * (a[4] * c + a[5] * s), t2 = a[6] + mu * (a[7] * c + a[8] * s);
  double d1 = mu * (-a[4] * s + a[5] * c), d2 = mu * (-a[7] * s + a[8] * c);
  double y = c * t2 - s * t1, dy = -s * t2 - c * t1 + c * d2 - s * d1;
  return {n * x - r.x * y, dn * x + n * dx - r.x * dy, n,
          n * (c * r.y + s * r.z) - r.x * (c * t1 + s * t2)};
}

// All directions, where Newton's method did not find the one: roots of f and, where two lie close
// together, of f on both sides of its extremum. Of several, the one with the smallest impulse.
bool LocalContact::search(Vec3 r, double& best_c, double& best_s) const {
  constexpr int kSteps = 24, kHalvings = 45;
  double best = 0;
  auto at = [&](double angle) { return slip(r, std::cos(angle), std::sin(angle)); };
  auto root = [&](double lo, double hi, double f_lo) {
    for (int i = 0; i < kHalvings; i++) {
      double mid = 0.5 * (lo + hi);
      ((at(mid).f <= 0) == (f_lo <= 0) ? lo : hi) = mid;
    }
    double angle = 0.5 * (lo + hi);
    Slip q = at(angle);
    if (q.normal > best && q.along <= 1e-12)
      best = q.normal, best_c = std::cos(angle), best_s = std::sin(angle);
  };
  Slip old = at(0);
  for (int k = 1; k <= kSteps; k++) {
    double lo = 2 * M_PI * (k - 1) / kSteps, hi = 2 * M_PI * k / kSteps;
    Slip now = at(hi);
    if ((now.f <= 0) != (old.f <= 0)) {
      root(lo, hi, old.f);
    } else if ((now.slope <= 0) != (old.slope <= 0)) {
      double a = lo, b = hi;
      for (int i = 0; i < kHalvings; i++) {
        double mid = 0.5 * (a + b);
        ((at(mid).slope <= 0) == (old.slope <= 0) ? a : b) = mid;
      }
      double mid = 0.5 * (a + b), f = at(mid).f;
      if ((f <= 0) != (old.f <= 0)) root(lo, mid, old.f), root(mid, hi, f);
    }
    old = now;
  }
  return best > 0;
}

Vec3 LocalContact::solve(Vec3 r, Vec3 old) const {
  if (r.x >= 0) return {};
  Vec3 stick = inverse * (-r);
  double m = mu;
  if (stick.x >= 0 && stick.y * stick.y + stick.z * stick.z <= m * m * stick.x * stick.x)
    return stick;
  if (m == 0) return {-r.x / A.m[0], 0, 0};
  double c = old.y, s = old.z;
  if (c == 0 && s == 0) c = stick.y, s = stick.z;
  if (c == 0 && s == 0) c = 1;
  double f = 1 / std::sqrt(c * c + s * s);
  c *= f, s *= f;
  bool found = false;
  for (int it = 0; it < 8 && !found; it++) {
    Slip q = slip(r, c, s);
    if (q.normal <= 0 || q.slope == 0) break;
    double d = std::min(0.7, std::max(-0.7, -q.f / q.slope));
    double c2 = c - d * s, s2 = s + d * c;
    f = 1 / std::sqrt(c2 * c2 + s2 * s2);
    c = f * c2, s = f * s2;
    if (std::fabs(d) < 1e-9) {
      q = slip(r, c, s);
      found = q.normal > 1e-6 * A.m[0] && q.along <= 0;
      break;
    }
  }
  // Without any (rounding at the cone's edge) at least nothing penetrates.
  if (!found && !search(r, c, s)) return {-r.x / A.m[0], 0, 0};
  double pn = -r.x / (A.m[0] + m * (A.m[1] * c + A.m[2] * s));
  return {pn, m * pn * c, m * pn * s};
}

}  // namespace hp
