#include "contact/coulomb_path.h"

#include <algorithm>
#include <cmath>

#include "math/dense.h"
#include "math/simd.h"
#include "tuning.h"

namespace hp {

namespace tune = tuning::contact;

// Multiplications of a Newton step: its matrix has three rows per contact, one for ln c, two idle.
double CoulombPath::cost() const {
  const double m = 3.0 * n_ + 3;
  return m * m * m / 3 + 40.0 * n_ * n_;
}

bool CoulombPath::begin(const Delassus& A, const std::vector<double>& beta,
                        const std::vector<LocalContact>& contacts) {
  const int rows = 3 * n_;
  speed_ = 0;
  for (double b : beta) speed_ = std::max(speed_, std::fabs(b));
  if (speed_ == 0) return false;
  unit_.resize(rows), mu_.resize(n_), beta_.resize(rows);
  delassus_.resize((size_t)rows * rows);
  for (int i = 0; i < n_; i++) {
    mu_[i] = contacts[i].mu;
    const double unit = tune::kPathUnit * contacts[i].tangent_step * speed_;
    for (int q = 0; q < 3; q++) {
      unit_[3 * i + q] = unit * (q == 0 ? 1 : mu_[i]);
      beta_[3 * i + q] = beta[3 * i + q] / speed_ * (q == 0 ? 1 : mu_[i]);
    }
  }
  for (int r = 0; r < rows; r++) {
    const double share = (r % 3 == 0 ? 1 : mu_[r / 3]) / speed_, *from = A.row(r);
    double* to = &delassus_[(size_t)r * rows];
    for (int l = 0; l < rows; l++) to[l] = share * from[l] * unit_[l];
  }
  here_.assign(rows + 1, 0.0);
  for (int i = 0; i < n_; i++) here_[3 * i] = tune::kPathStart;
  start_.assign(rows, 0.0);
  evaluate(here_);
  start_ = value_;
  direction_.assign(rows + 1, 0.0);
  direction_[rows] = -1;
  return true;
}

// Rows of value_ and matrix_ of contact i, from its w. The spectral values of d = x - y are d_0 -+ |d_t|
// along (1, -+u) / 2, and a function of d has those of its values there.
void CoulombPath::smooth(int i, double c, const double* x) {
  const int rows = 3 * n_, width = rows + 3;
  const double *w = &w_[3 * i], L = std::sqrt(w[1] * w[1] + w[2] * w[2] + c * c);
  const double y[3] = {w[0] + L - c, w[1], w[2]}, d[3] = {x[0] - y[0], x[1] - y[1], x[2] - y[2]};
  const double r = std::sqrt(d[1] * d[1] + d[2] * d[2]), l1 = d[0] - r, l2 = d[0] + r,
               e = 4 * c * c, g1 = std::sqrt(l1 * l1 + e), g2 = std::sqrt(l2 * l2 + e);
  const double u[2] = {r > 0 ? d[1] / r : 1, r > 0 ? d[2] / r : 0};
  const double half = 0.25 * (g2 - g1), *first = &start_[3 * i];
  value_[3 * i] = 0.5 * (x[0] + y[0]) - 0.25 * (g1 + g2) - c * first[0];
  value_[3 * i + 1] = 0.5 * (x[1] + y[1]) - half * u[0] - c * first[1];
  value_[3 * i + 2] = 0.5 * (x[2] + y[2]) - half * u[1] - c * first[2];

  // G: the root's derivative by d; F has (1 - G) / 2 by x and (1 + G) / 2 by y.
  const double h1 = l1 / g1, h2 = l2 / g2, mean = 0.5 * (h1 + h2), odd = 0.5 * (h2 - h1),
               across = (l1 + l2) / (g1 + g2);  // (g2 - g1) / (l2 - l1)
  const double G[3][3] = {
      {mean, odd * u[0], odd * u[1]},
      {odd * u[0], across + (mean - across) * u[0] * u[0], (mean - across) * u[0] * u[1]},
      {odd * u[1], (mean - across) * u[0] * u[1], across + (mean - across) * u[1] * u[1]}};
  const double slip[2] = {w[1] / L, w[2] / L};  // of |w_t|
  const double q1 = 0.5 * e / g1, q2 = 0.5 * e / g2;
  const double root[3] = {0.5 * (q1 + q2), 0.5 * (q2 - q1) * u[0], 0.5 * (q2 - q1) * u[1]};
  const double* a = &delassus_[(size_t)3 * i * rows];
  for (int q = 0; q < 3; q++) {
    double B[3];
    for (int l = 0; l < 3; l++) B[l] = 0.5 * ((q == l) + G[q][l]);
    double* row = &matrix_[(size_t)(3 * i + q) * width];
    std::fill(row, row + width, 0.0);
    for (int l = 0; l < 3; l++) row[3 * i + l] = 0.5 * ((q == l) - G[q][l]);
    add_scaled(row, B[0], a, B[1] + B[0] * slip[0], a + rows, B[2] + B[0] * slip[1], a + 2 * rows,
               rows);
    row[rows] = B[0] * (c * c / L - c) - root[q] - c * first[q];
  }
}

// F(x, c) - c F(x_0, 1) and its derivatives at a point; its length.
double CoulombPath::evaluate(const Point& at) {
  const int rows = 3 * n_;
  const double c = elementary::exp(at[rows]);
  value_.resize(rows), w_.resize(rows);
  matrix_.resize((size_t)(rows + 3) * (rows + 3));
  double sum = 0;
  for (int i = 0; i < rows; i++)
    w_[i] = beta_[i] + inner(&delassus_[(size_t)i * rows], at.data(), rows);
  for (int i = 0; i < n_; i++) smooth(i, c, &at[3 * i]);
  for (double v : value_) sum += v * v;
  return std::sqrt(sum);
}

// One Newton step of trial_ back onto the path, across direction_.
bool CoulombPath::newton(WorkBudget& budget) {
  const int rows = 3 * n_, width = rows + 3;
  double* last = &matrix_[(size_t)rows * width];
  std::copy(direction_.begin(), direction_.end(), last);
  last[rows + 1] = last[rows + 2] = 0;
  for (int q = 1; q < 3; q++) {
    std::fill(last + q * width, last + (q + 1) * width, 0.0);
    last[q * width + rows + q] = 1;
  }
  value_.resize(width);
  for (int i = 0; i < rows; i++) value_[i] = -value_[i];
  value_[rows] = value_[rows + 1] = value_[rows + 2] = 0;
  budget.spend(cost());
  steps_++;
  const bool regular = solve_dense(matrix_.data(), width, tune::kSingularPivot, value_.data());
  for (int i = 0; i <= rows; i++) trial_[i] += value_[i];
  return regular;
}

// From here_ so far along direction_, and back onto the path, into trial_. False if it is too far.
bool CoulombPath::advance(double length, WorkBudget& budget) {
  const int rows = 3 * n_;
  trial_.resize(rows + 1);
  for (int i = 0; i <= rows; i++) trial_[i] = here_[i] + length * direction_[i];
  double before = 1e300;
  for (int turn = 0; turn < tune::kPathCorrections; turn++) {
    const double off = evaluate(trial_);
    if (off < tune::kPathWidth * elementary::exp(trial_[rows])) return true;
    if (!(off <= tune::kPathContraction * before) || !newton(budget)) return false;
    before = off;
  }
  return false;
}

// Of the impulses p_ at here_ [m/s].
double CoulombPath::residual(const std::vector<LocalContact>& contacts) {
  p_.resize(3 * n_);
  double worst = 0;
  for (int i = 0; i < n_; i++) {
    const double back = mu_[i] > 0 ? speed_ / mu_[i] : 0;
    const double* w = &w_[3 * i];
    const double slip[3] = {speed_ * w[0], back * w[1], back * w[2]};
    for (int q = 0; q < 3; q++) p_[3 * i + q] = unit_[3 * i + q] * here_[3 * i + q];
    worst = std::max(worst, contacts[i].residual(&p_[3 * i], slip));
  }
  return worst;
}

// From here_ on, until impulses are within the tolerance, into p, or none are to be had: how far the
// best that were met are from an answer. p misses it by `least` at first.
double CoulombPath::walk(const std::vector<LocalContact>& contacts, double tolerance, double least,
                         WorkBudget& budget, std::vector<double>& p) {
  const int rows = 3 * n_;
  double length = tune::kPathLength;
  while (length > tune::kPathShortest && steps_ < tune::kPathSteps && budget.left() > cost() &&
         here_[rows] > tune::kPathEnd) {
    const int before = steps_;
    if (!advance(length, budget)) {
      length *= tune::kPathShorter;
      continue;
    }
    double way = 0;
    for (int i = 0; i <= rows; i++) {
      direction_[i] = trial_[i] - here_[i];
      way += direction_[i] * direction_[i];
    }
    for (double& d : direction_) d /= std::sqrt(way);
    here_ = trial_;
    double farthest = 0;
    for (int i = 0; i < rows; i++) farthest = std::max(farthest, std::fabs(here_[i]));
    if (farthest > tune::kPathFarthest) break;
    const double missed = residual(contacts);
    if (missed < least) least = missed, p = p_;
    if (least < tolerance) break;
    if (steps_ - before <= tune::kPathEasy) length *= 2;
  }
  return least;
}

bool CoulombPath::follow(const Delassus& A, const std::vector<double>& beta,
                         const std::vector<LocalContact>& contacts, double tolerance, double missed,
                         WorkBudget& budget, std::vector<double>& p) {
  steps_ = 0;
  n_ = (int)contacts.size();
  WorkBudget mine;
  mine.begin(std::min(tune::kPathWork, 0.25 * budget.left()));
  if (tune::kPathUsual * cost() > mine.left()) return false;
  if (!begin(A, beta, contacts)) return false;
  const double least = walk(contacts, tolerance, missed, mine, p);
  budget.spend(mine.work());
  return least < missed;
}

}  // namespace hp
