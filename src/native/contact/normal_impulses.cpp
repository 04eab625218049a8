// Normal impulses alone, friction held (contact_problem.h).
#include <cmath>

#include "contact/contact_problem.h"
#include "math/dense.h"
#include "tuning.h"

namespace hp {

namespace tune = tuning::contact;

// The normal rows and columns of A, which is symmetric, by themselves.
void ContactProblem::gather_normals() {
  const int n = size();
  if (normals_.size() == (size_t)n * n) return;
  normals_.resize((size_t)n * n);
  for (int i = 0; i < n; i++) {
    const double* row = A.row(3 * i);
    for (int j = 0; j < n; j++) normals_[(size_t)i * n + j] = row[3 * j];
  }
  budget.spend(tune::kScatteredWork * n * n);
}

// The equations A p_n = -q of the active contacts, into matrix_ and right_.
void ContactProblem::normal_rows() {
  const int n = size(), k = (int)set_.size();
  matrix_.resize((size_t)k * k);
  right_.resize(k);
  for (int a = 0; a < k; a++) {
    const double* row = &normals_[(size_t)set_[a] * n];
    double* out = &matrix_[(size_t)a * k];
    for (int b = 0; b < k; b++) out[b] = row[set_[b]];
    out[a] *= 1 + tune::kCompliance;
    right_[a] = -q_[set_[a]];
  }
}

// Their answer, and 0 for the others, into x_.
void ContactProblem::solve_active() {
  const int n = size();
  set_.clear();
  for (int i = 0; i < n; i++)
    if (active_[i]) set_.push_back(i);
  const int k = (int)set_.size();
  budget.spend((double)k * k * k / 3 + tune::kScatteredWork * k * n);
  normal_rows();
  least_pivot_.resize(k);
  double least = 0;
  for (int a = 0; a < k; a++) {
    least_pivot_[a] = tune::kCholeskyPivot * matrix_[(size_t)a * (k + 1)];
    least = std::max(least, least_pivot_[a]);
  }
  if (!solve_mixed(matrix_.data(), k, k, least, right_.data())) {  // rounding has used up a pivot
    normal_rows();
    factor_cholesky(matrix_.data(), k, least_pivot_.data());
    solve_cholesky(matrix_.data(), k, right_.data());
  }
  x_.assign(n, 0);
  for (int a = 0; a < k; a++) x_[set_[a]] = right_[a];
}

// Marks active contacts that pull and others that approach; returns how many there are, and the last.
int ContactProblem::find_wrong(double tolerance, int& last) {
  const int n = size();
  int wrong = 0;
  wrong_.assign(n, 0);
  // Redundant contacts trade rounding among themselves: that is no reason to pivot.
  double largest = 0;
  for (double x : x_) largest = std::max(largest, std::fabs(x));
  for (int i = 0; i < n; i++) {
    if (active_[i]) {
      wrong_[i] = x_[i] < -tune::kPull * largest;
    } else {
      const double* row = &normals_[(size_t)i * n];
      double y = q_[i];
      for (int j : set_) y += row[j] * x_[j];
      wrong_[i] = y < -tolerance;
    }
    if (wrong_[i]) wrong++, last = i;
  }
  return wrong;
}

// 0 <= p_n, A p_n + q >= 0, complementary, where friction is held and q is what it and beta give the
// normal rows: block principal pivoting, with single pivots where blocks cycle.
void ContactProblem::solve_normals(double tolerance) {
  const int n = size();
  gather_normals();
  q_.resize(n);
  x_.assign(n, 0);
  active_.resize(n);
  for (int i = 0; i < n; i++) {
    double s = beta[3 * i];
    for (int j = 0; j < n; j++) {
      const double* a = A.block(i, j);
      s += a[1] * p[3 * j + 1] + a[2] * p[3 * j + 2];
    }
    q_[i] = s;
    active_[i] = p[3 * i] > 0;
  }
  int fewest = n + 1, patience = tune::kBlockPivots;
  for (int it = 0; it < tune::kPivots && (it == 0 || !budget.spent()); it++) {
    solve_active();
    int last = -1;
    const int wrong = find_wrong(tolerance, last);
    if (wrong == 0) break;
    const bool all = wrong < fewest || patience > 0;
    if (wrong < fewest)
      fewest = wrong, patience = tune::kBlockPivots;
    else
      patience--;
    for (int i = 0; i < n; i++)
      if (wrong_[i] && (all || i == last)) active_[i] = !active_[i];
  }
  for (int i = 0; i < n; i++) p[3 * i] = std::max(x_[i], 0.0);
}

// Rounds of normal impulses alone, each followed by the friction that they bear; the best is kept.
void ContactProblem::settle_normals(double tolerance, SolveReport& report) {
  best_ = p;  // pivots that do not end must not count
  for (int r = 0;
       r < tune::kNormalRounds && report.normal >= tolerance && (r == 0 || !budget.spent()); r++) {
    solve_normals(tune::kNormalGoal * tolerance);
    if (r >= tune::kFrictionRounds)
      for (int i = 0; i < size(); i++)
        if (elementary::hypot(p[3 * i + 1], p[3 * i + 2]) >
            local_[i].mu * p[3 * i] + tune::kConeRounding)
          p[3 * i + 1] = p[3 * i + 2] = 0;
    project();  // a normal impulse that got smaller takes its friction along
    product();
    report.sweeps++;
    const double after = residual(true);
    if (after < report.normal) best_ = p, report.normal = after;
  }
  p = best_;
  product();
  report.residual = residual(false);
}

// Friction that did not settle may push along the slip: of 10 g under a tonne it made 400 m/s. It is
// dropped where it does, or where the normal impulse does not bear it, and the normal rows are solved
// for again. With no friction left they always can be.
void ContactProblem::drop_driving_friction(double tolerance, SolveReport& report) {
  best_ = p;
  for (int r = 0; r < tune::kDroppingRounds && !budget.spent(); r++) {
    bool drops = false;
    for (int i = 0; i < size(); i++) {
      double* t = &p[3 * i + 1];
      const double force = elementary::hypot(t[0], t[1]);
      const double along = t[0] * w_[3 * i + 1] + t[1] * w_[3 * i + 2];
      if (along <= tune::kDrivingSlip * force &&
          force <= local_[i].mu * p[3 * i] * (1 + tune::kConeRounding))
        continue;
      t[0] = t[1] = 0;
      drops = true;
    }
    if (!drops && (r == 0 || residual(true) < tune::kEnough * tolerance)) break;
    solve_normals(tune::kNormalGoal * tolerance);
    product();
    report.sweeps++;
  }
  project();
  product();
  const double normal = residual(true);
  if (normal > std::max(report.normal, tune::kEnough * tolerance)) {  // rounds that did not end
    p = best_;
    product();
  } else {
    report.normal = normal;
  }
  report.residual = residual(false);
}

}  // namespace hp
