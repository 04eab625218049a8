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
  bool dropped = false;
  for (int i = 0; i < n; i++) {
    if (s < set_.size() && set_[s] == i) {
      s++;
      continue;
    }
    double* q = &p[3 * i];
    dropped |= q[0] != 0 || q[1] != 0 || q[2] != 0;
    q[0] = q[1] = q[2] = 0;
  }
  if (dropped) product();
}

// How a contact would slip: y = p_t - k w_t and the radius of its friction's disc.
struct ContactProblem::Slip {
  double y, z, length, limit;
  bool slips;
};

ContactProblem::Slip ContactProblem::slip_of(int contact) const {
  const LocalContact& c = local_[contact];
  const double *q = &p[3 * contact], *w = &w_[3 * contact], k = c.tangent_step;
  Slip s;
  s.y = q[1] - k * w[1], s.z = q[2] - k * w[2];
  s.length = std::sqrt(s.y * s.y + s.z * s.z), s.limit = c.mu * std::max(q[0], 0.0);
  s.slips = s.length > s.limit || c.mu <= 0;
  return s;
}

// The order of a step's unknowns: all normal rows and the tangents of what sticks, whose equations are
// rows of A and symmetric, then the tangents of what slips. Returns how many the former are.
int ContactProblem::order_unknowns() {
  const int m = (int)set_.size();
  unknown_.clear();
  slips_.clear();
  for (int a = 0; a < m; a++) {
    slips_.push_back(slip_of(set_[a]).slips);
    for (int r = 0; r < (slips_[a] ? 1 : 3); r++) unknown_.push_back(3 * set_[a] + r);
  }
  const int symmetric = (int)unknown_.size();
  for (int a = 0; a < m; a++)
    for (int r = 1; r < 3 && slips_[a]; r++) unknown_.push_back(3 * set_[a] + r);
  place_.assign(3 * (size_t)size(), -1);
  for (size_t k = 0; k < unknown_.size(); k++) place_[unknown_[k]] = (int)k;
  return symmetric;
}

// The equations of the step dp, into matrix_ and right_: w_n = 0, and w_t = 0 of what sticks, of which the
// upper triangle is enough; then those of what slips.
void ContactProblem::newton_rows(int symmetric, double damping) {
  const int n = (int)unknown_.size();
  matrix_.resize((size_t)n * n);
  right_.resize(n);
  for (int k = 0; k < n; k++) {
    const double* row = A.row(unknown_[k]);
    double* out = &matrix_[(size_t)k * n];
    for (int l = k < symmetric ? k : 0; l < n; l++) out[l] = row[unknown_[l]];
    if (k >= symmetric) continue;
    const LocalContact& c = local_[unknown_[k] / 3];
    out[k] += unknown_[k] % 3 == 0 ? damping * c.A.m[0] : damping / c.tangent_step;
    right_[k] = -w_[unknown_[k]];
  }
  for (int k = symmetric; k < n; k += 2) slip_rows(unknown_[k] / 3, k);
}

// The tangential equations of a contact that slips, rows k and k + 1: p_t = mu p_n y/|y| with
// y = p_t - k w_t. With u = y/|y| and P = (mu p_n/|y|)(I - u u^T), divided by k:
//     P A_t dp + (I - P)/k dp_t - (mu u/k) dp_n = -(p_t - mu p_n u)/k.
void ContactProblem::slip_rows(int contact, int at) {
  const LocalContact& c = local_[contact];
  const Slip s = slip_of(contact);
  const double *q = &p[3 * contact], k = c.tangent_step;
  const int n = (int)unknown_.size(), normal = place_[3 * contact];
  const double u = s.length > 0 ? s.y / s.length : 0, v = s.length > 0 ? s.z / s.length : 0,
               g = s.length > 0 ? s.limit / s.length : 0;
  const double p11 = g * (1 - u * u), p12 = -g * u * v, p22 = g * (1 - v * v);
  double *J1 = &matrix_[(size_t)at * n], *J2 = J1 + n;
  for (int b = 0; b < n; b++) {
    const double r1 = J1[b], r2 = J2[b];
    J1[b] = p11 * r1 + p12 * r2;
    J2[b] = p12 * r1 + p22 * r2;
  }
  J1[normal] -= c.mu * u / k, J1[at] += (1 - p11) / k, J1[at + 1] -= p12 / k;
  J2[normal] -= c.mu * v / k, J2[at] -= p12 / k, J2[at + 1] += (1 - p22) / k;
  right_[at] = -(q[1] - s.limit * u) / k;
  right_[at + 1] = -(q[2] - s.limit * v) / k;
}

// Goes as much of a step from start_ as brings the merit under `bound`, halving it; false if no share
// of it does.
bool ContactProblem::take_share(const double* step, double bound) {
  const int n3 = 3 * size(), n = (int)unknown_.size();
  double share = 1;
  for (int attempt = 0; attempt < tune::kNewtonShares; attempt++, share *= 0.5) {
    for (int i = 0; i < n3; i++) p[i] = (1 - share) * start_[i];
    for (int k = 0; k < n; k++) p[unknown_[k]] = start_[unknown_[k]] + share * step[k];
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
  const double cost =
      (double)m3 * m3 * m3 / 3 + 2 * tune::kScatteredWork * m3 * m3 + tune::kUnknownWork * m3;
  if (!budget.affords(cost)) {
    barred_ = true;
    p = start_;
    product();
    return false;
  }
  budget.spend(cost);
  const int symmetric = order_unknowns();
  newton_rows(symmetric, damping);
  if (solve_mixed(matrix_.data(), m3, symmetric, tune::kSingularPivot, right_.data()) &&
      take_share(right_.data(), bound))
    return true;
  p = start_;
  product();
  return false;
}

}  // namespace hp
