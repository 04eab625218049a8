// Damped Newton steps on the natural map (contact_problem.h).
#include <cmath>

#include "contact/contact_problem.h"
#include "math/dense.h"
#include "tuning.h"

namespace hp {

namespace tune = tuning::contact;

// The contacts that carry by the natural map, p_n A_nn >= w_n, are the set of a Newton step; the
// impulses of all others become zero.
void ContactProblem::drop_unloaded() {
  const int n = size();
  set_.clear();
  for (int i = 0; i < n; i++)
    if (p[3 * i] * local_[i].A.m[0] >= w_[3 * i]) set_.push_back(i);
  size_t s = 0;
  for (int i = 0; i < n; i++) {
    if (s < set_.size() && set_[s] == i)
      s++;
    else
      p[3 * i] = p[3 * i + 1] = p[3 * i + 2] = 0;
  }
  product();
}

// The three equations of the set's contact a for the step dp, into matrix_ and right_. The normal row
// is w_n = 0; a contact that sticks has w_t = 0.
void ContactProblem::newton_rows(int a, double damping) {
  const int m = (int)set_.size(), m3 = 3 * m, i = set_[a];
  const LocalContact& c = local_[i];
  const double *q = &p[3 * i], *w = &w_[3 * i];
  double* J[3];
  for (int r = 0; r < 3; r++) {
    J[r] = &matrix_[(size_t)(3 * a + r) * m3];
    for (int b = 0; b < m; b++)
      for (int l = 0; l < 3; l++) J[r][3 * b + l] = A.block(i, set_[b])[r * A.stride() + l];
  }
  const double k = c.tangent_step, y = q[1] - k * w[1], z = q[2] - k * w[2],
               length = std::sqrt(y * y + z * z), limit = c.mu * std::max(q[0], 0.0);
  J[0][3 * a] += damping * c.A.m[0];
  right_[3 * a] = -w[0];
  if (length > limit || c.mu <= 0) return slip_rows(a, J, y, z, limit);
  for (int r = 1; r < 3; r++) {
    J[r][3 * a + r] += damping / k;
    right_[3 * a + r] = -w[r];
  }
}

// The tangential equations of a contact that slips, p_t = mu p_n y/|y| with y = p_t - k w_t. With
// u = y/|y| and P = (mu p_n/|y|)(I - u u^T), divided by k:
//     P A_t dp + (I - P)/k dp_t - (mu u/k) dp_n = -(p_t - mu p_n u)/k.
void ContactProblem::slip_rows(int a, double* const J[3], double y, double z, double limit) {
  const LocalContact& c = local_[set_[a]];
  const double *q = &p[3 * set_[a]], k = c.tangent_step, length = std::sqrt(y * y + z * z);
  const int m3 = 3 * (int)set_.size();
  const double u = length > 0 ? y / length : 0, v = length > 0 ? z / length : 0,
               g = length > 0 ? limit / length : 0;
  const double p11 = g * (1 - u * u), p12 = -g * u * v, p22 = g * (1 - v * v);
  for (int b = 0; b < m3; b++) {
    double r1 = J[1][b], r2 = J[2][b];
    J[1][b] = p11 * r1 + p12 * r2;
    J[2][b] = p12 * r1 + p22 * r2;
  }
  J[1][3 * a] -= c.mu * u / k, J[1][3 * a + 1] += (1 - p11) / k, J[1][3 * a + 2] -= p12 / k;
  J[2][3 * a] -= c.mu * v / k, J[2][3 * a + 1] -= p12 / k, J[2][3 * a + 2] += (1 - p22) / k;
  right_[3 * a + 1] = -(q[1] - limit * u) / k;
  right_[3 * a + 2] = -(q[2] - limit * v) / k;
}

// Goes as much of a step from start_ as brings the merit under `bound`, halving it; false if no share
// of it does.
bool ContactProblem::take_share(const double* step, double bound) {
  const int n3 = 3 * size(), m = (int)set_.size();
  double share = 1;
  for (int attempt = 0; attempt < tune::kNewtonShares; attempt++, share *= 0.5) {
    for (int i = 0; i < n3; i++) p[i] = (1 - share) * start_[i];
    for (int a = 0; a < m; a++)
      for (int r = 0; r < 3; r++)
        p[3 * set_[a] + r] = start_[3 * set_[a] + r] + share * step[3 * a + r];
    project();
    product();
    if (merit() < bound * (1 - tune::kNewtonDecrease)) return true;
  }
  return false;
}

// One damped step of Newton's method on the natural map: a contact carries, w_n = 0, or not, p = 0; it
// sticks, w_t = 0, or slips (slip_rows). `damping` is relative to the diagonal of A. False if no share
// of the step brings the merit under `bound`, or if it costs more than is left; p is then as it was.
bool ContactProblem::newton_step(double damping, double bound) {
  start_ = p;
  drop_unloaded();
  const int m = (int)set_.size(), m3 = 3 * m;
  const double cost = (double)m3 * m3 * m3 / 3;
  if (!budget.affords(cost)) {
    barred_ = true;
    p = start_;
    product();
    return false;
  }
  budget.spend(cost);
  matrix_.resize((size_t)m3 * m3);
  right_.resize(m3);
  for (int a = 0; a < m; a++) newton_rows(a, damping);
  if (solve_dense(matrix_.data(), m3, tune::kSingularPivot, right_.data()) &&
      take_share(right_.data(), bound))
    return true;
  p = start_;
  product();
  return false;
}

}  // namespace hp
