#include "contact/coulomb.h"

#include "tuning.h"

namespace hp {

namespace tune = tuning::contact;

namespace {

double polynomial(const double* f, int degree, double t) {
  double y = f[degree];
  for (int i = degree - 1; i >= 0; i--) y = y * t + f[i];
  return y;
}

// Roots in [-1, 1] of f[0] + f[1] t + ...: between those of its derivative it is monotone.
int polynomial_roots(const double* f, int degree, double* roots) {
  if (degree <= 0) return 0;
  double derivative[4] = {}, turns[4] = {};
  for (int i = 0; i < degree; i++) derivative[i] = (i + 1) * f[i + 1];
  const int n = polynomial_roots(derivative, degree - 1, turns);
  turns[n] = 1;
  int found = 0;
  double lo = -1, f_lo = polynomial(f, degree, lo);
  for (int k = 0; k <= n; k++) {
    const double f_hi = polynomial(f, degree, turns[k]);
    if ((f_hi <= 0) != (f_lo <= 0)) {
      double from = lo, to = turns[k];
      for (int i = 0; i < tune::kRootHalvings; i++) {
        const double mid = 0.5 * (from + to);
        ((polynomial(f, degree, mid) <= 0) == (f_lo <= 0) ? from : to) = mid;
      }
      roots[found++] = 0.5 * (from + to);
    }
    lo = turns[k], f_lo = f_hi;
  }
  return found;
}

}  // namespace

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

double LocalContact::friction_residual(const double* p, const double* w) const {
  const double normal = normal_residual(p, w), both = squared_residual(p, w);
  return std::sqrt(std::max(0.0, both - normal * normal));
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

// All directions, where Newton's method did not find the one. With c, s = (1 - t^2, 2 t)/(1 + t^2)
// f is a polynomial of degree 4 in t; |t| <= 1 is half the circle, and -c, -s the other half. Of
// several roots, the one with the smallest impulse; where friction opposes the slip of none (rounding
// at the cone's edge), the one that slips least.
bool LocalContact::search(Vec3 r, double rounding, double& best_c, double& best_s) const {
  const double* a = A.m;
  double best = 0, least = 1e300;
  for (double side : {1.0, -1.0}) {
    const double C[3] = {side, 0, -side}, S[3] = {0, 2 * side, 0}, Q[3] = {1, 0, 1};
    double normal[3], across[3], stick[3], y[3], z[3], f[5] = {};
    for (int i = 0; i < 3; i++) {
      normal[i] = a[0] * Q[i] + mu * (a[1] * C[i] + a[2] * S[i]);
      across[i] = C[i] * r.z - S[i] * r.y;
      stick[i] = r.x * (C[i] * a[6] - S[i] * a[3]);
      y[i] = r.x * mu * (C[i] * a[7] - S[i] * a[4]);
      z[i] = r.x * mu * (C[i] * a[8] - S[i] * a[5]);
    }
    for (int i = 0; i < 3; i++)
      for (int j = 0; j < 3; j++)
        f[i + j] += normal[i] * across[j] - stick[i] * Q[j] - y[i] * C[j] - z[i] * S[j];
    double roots[4];
    const int n = polynomial_roots(f, 4, roots);
    for (int i = 0; i < n; i++) {
      const double t = roots[i], q = side / (1 + t * t), c = q * (1 - t * t), s = q * 2 * t;
      const Slip slipping = slip(r, c, s);
      if (slipping.normal <= 0) continue;
      if (slipping.along <= rounding) {
        if (slipping.normal <= best) continue;
        best = slipping.normal;
      } else {
        if (best > 0 || slipping.along >= least * slipping.normal) continue;
        least = slipping.along / slipping.normal;
      }
      best_c = c, best_s = s;
    }
  }
  return best > 0 || least < 1e300;
}

Vec3 LocalContact::solve(Vec3 r, Vec3 old) const {
  if (r.x >= 0) return {};
  Vec3 stick = inverse * (-r);
  stick -= inverse * (r + A * stick);  // Cramer's rule loses digits where A is ill-conditioned
  double m = mu;
  if (stick.x >= 0 && stick.y * stick.y + stick.z * stick.z <= m * m * stick.x * stick.x)
    return stick;
  if (m == 0) return {-r.x / A.m[0], 0, 0};
  double c = old.y, s = old.z;
  if (c == 0 && s == 0) c = stick.y, s = stick.z;
  if (c == 0 && s == 0) c = 1;
  double f = 1 / std::sqrt(c * c + s * s);
  c *= f, s *= f;
  const double* a = A.m;
  const double rounding = tune::kSlipRounding * std::max(a[0], std::max(a[4], a[8])) * norm(r);
  bool found = false;
  for (int it = 0; it < tune::kSlipSteps && !found; it++) {
    Slip q = slip(r, c, s);
    if (q.normal <= 0 || q.slope == 0) break;
    double d = std::min(tune::kSlipLargestStep, std::max(-tune::kSlipLargestStep, -q.f / q.slope));
    double c2 = c - d * s, s2 = s + d * c;
    f = 1 / std::sqrt(c2 * c2 + s2 * s2);
    c = f * c2, s = f * s2;
    if (std::fabs(d) < tune::kSlipSettled) {
      q = slip(r, c, s);
      found = q.normal > tune::kSlipJamming * a[0] && q.along <= rounding;
      break;
    }
  }
  // Without any (rounding, where A is all but singular) at least nothing penetrates.
  if (!found && !search(r, rounding, c, s)) return {-r.x / a[0], 0, 0};
  double pn = -r.x / (a[0] + m * (a[1] * c + a[2] * s));
  return {pn, m * pn * c, m * pn * s};
}

}  // namespace hp
