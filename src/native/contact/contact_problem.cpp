#include "contact/contact_problem.h"

#include <cmath>

#include "math/simd.h"
#include "tuning.h"

namespace hp {

namespace tune = tuning::contact;

void ContactProblem::clear(int capacity) {
  stride_ = 3 * (size_t)capacity;
  if (delassus_.size() < stride_ * stride_) delassus_.resize(stride_ * stride_);
  beta.clear();
  p.clear();
  local_.clear();
  group_count_ = 0;
}

void ContactProblem::add(const double* beta3, const double* warm3, double mu, int pair) {
  const int n = size();
  double* a = A(n, n);
  double floor = tune::kDiagonalShare * std::max(a[0], tune::kLeastInverseMass);  // a contact between immovable things
  Mat3 B;
  for (int q = 0; q < 3; q++) a[q * (stride_ + 1)] += floor;
  for (int q = 0; q < 9; q++) B.m[q] = a[(q / 3) * stride_ + q % 3];
  local_.emplace_back();
  local_.back().set(B, mu);
  beta.insert(beta.end(), beta3, beta3 + 3);
  p.insert(p.end(), warm3, warm3 + 3);
  p[3 * n] = std::max(p[3 * n], 0.0);
  clamp_friction(&p[3 * n], mu);

  size_t g = 0;
  while (g < group_count_ && groups_[g].pair != pair) g++;
  if (g == group_count_) {
    group_count_++;
    if (groups_.size() < group_count_) groups_.emplace_back();
    groups_[g].pair = pair;
    groups_[g].rows.clear();
    groups_[g].A.clear();
  }
  groups_[g].rows.push_back(n);
}

void ContactProblem::finish_groups() {
  for (size_t i = 0; i < group_count_; i++) {
    Group& g = groups_[i];
    size_t m = g.rows.size();
    if (g.A.size() == 9 * m * m) continue;
    g.A.resize(9 * m * m);
    for (size_t a = 0; a < m; a++)
      for (size_t b = 0; b < m; b++)
        for (int r = 0; r < 3; r++)
          for (int c = 0; c < 3; c++)
            g.A[(3 * a + r) * 3 * m + 3 * b + c] = A(g.rows[a], g.rows[b])[r * stride_ + c];
  }
}

void ContactProblem::product() {
  const int n3 = 3 * size();
  w_ = beta;
  double* w = w_.data();
  for (int i = 0; i < n3; i++) {
    double f = p[i];
    if (f == 0) continue;
    add_scaled(w, f, &delassus_[(size_t)i * stride_], n3);
  }
}

void ContactProblem::project() {
  for (int i = 0; i < size(); i++) {
    p[3 * i] = std::max(p[3 * i], 0.0);
    clamp_friction(&p[3 * i], local_[i].mu);
  }
}

double ContactProblem::residual(bool normal_only) const {
  double worst = 0;
  for (int i = 0; i < size(); i++) {
    const LocalContact& c = local_[i];
    worst = std::max(worst, normal_only ? c.normal_residual(&p[3 * i], &w_[3 * i])
                                        : c.residual(&p[3 * i], &w_[3 * i]));
  }
  return worst;
}

double ContactProblem::merit() const {
  double sum = 0;
  for (int i = 0; i < size(); i++) sum += local_[i].squared_residual(&p[3 * i], &w_[3 * i]);
  return sum;
}

// The contacts of one pair, by sweeps among themselves; then everybody's velocities follow.
void ContactProblem::settle(Group& g, double tolerance) {
  const int m = (int)g.rows.size(), m3 = 3 * m;
  old_.resize(m3);
  own_.resize(m3);
  for (int a = 0; a < m; a++)
    for (int q = 0; q < 3; q++) {
      old_[3 * a + q] = p[3 * g.rows[a] + q];
      own_[3 * a + q] = w_[3 * g.rows[a] + q];
    }
  for (int it = 0; it < tune::kPairSweeps; it++) {
    double change = 0;
    for (int turn = 0; turn < m; turn++) {
      int a = it % 2 == 0 ? turn : m - 1 - turn, i = g.rows[a];
      const LocalContact& c = local_[i];
      Vec3 now = load3(&p[3 * i]), q = c.solve(load3(&own_[3 * a]) - c.A * now, now);
      Vec3 d = q - now;
      if (d.x == 0 && d.y == 0 && d.z == 0) continue;
      store3(&p[3 * i], q);
      change = std::max(change, std::max(std::fabs(d.x) * c.A.m[0],
                                         std::max(std::fabs(d.y), std::fabs(d.z)) / c.tangent_step));
      const double *r0 = &g.A[(size_t)3 * a * m3], *r1 = r0 + m3, *r2 = r1 + m3;
      double* own = own_.data();
      for (int j = 0; j < m3; j++) own[j] += d.x * r0[j] + d.y * r1[j] + d.z * r2[j];
    }
    if (m == 1 || change < tolerance) break;
  }
  const int n3 = 3 * size();
  double* w = w_.data();
  for (int a = 0; a < m; a++) {
    int i = g.rows[a];
    double d0 = p[3 * i] - old_[3 * a], d1 = p[3 * i + 1] - old_[3 * a + 1],
           d2 = p[3 * i + 2] - old_[3 * a + 2];
    if (d0 == 0 && d1 == 0 && d2 == 0) continue;
    const double *r0 = &delassus_[(size_t)(3 * i) * stride_], *r1 = r0 + stride_, *r2 = r1 + stride_;
    add_scaled(w, d0, r0, d1, r1, d2, r2, n3);
  }
}

// One step of Newton's method on the natural map (Alart, Curnier 1991): who carries has w_n = 0;
// who sticks w_t = 0; who slips p_t = mu p_n y/|y| with y = p_t - k w_t. False if no share of the
// step brings the merit under `bound`; p is then as it was.
bool ContactProblem::newton(double damping, double bound) {
  const int n = size();
  set_.clear();
  for (int i = 0; i < n; i++)
    if (p[3 * i] * local_[i].A.m[0] >= w_[3 * i]) set_.push_back(i);
  const int m = (int)set_.size(), m3 = 3 * m;
  start_ = p;
  // Those that carry nothing are let go first.
  size_t s = 0;
  for (int i = 0; i < n; i++) {
    if (s < set_.size() && set_[s] == i)
      s++;
    else
      p[3 * i] = p[3 * i + 1] = p[3 * i + 2] = 0;
  }
  product();
  jacobian_.resize((size_t)m3 * m3);
  right_.resize(m3);
  for (int a = 0; a < m; a++) {
    const int i = set_[a];
    const LocalContact& c = local_[i];
    const double *q = &p[3 * i], *w = &w_[3 * i];
    double* J[3];
    for (int r = 0; r < 3; r++) {
      J[r] = &jacobian_[(size_t)(3 * a + r) * m3];
      for (int b = 0; b < m; b++)
        for (int l = 0; l < 3; l++) J[r][3 * b + l] = A(i, set_[b])[r * stride_ + l];
    }
    const double k = c.tangent_step, y = q[1] - k * w[1], z = q[2] - k * w[2],
                 length = std::sqrt(y * y + z * z), limit = c.mu * std::max(q[0], 0.0);
    J[0][3 * a] += damping * c.A.m[0];
    right_[3 * a] = -w[0];
    if (length <= limit && c.mu > 0) {
      for (int r = 1; r < 3; r++) {
        J[r][3 * a + r] += damping / k;
        right_[3 * a + r] = -w[r];
      }
      continue;
    }
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

  double* x = right_.data();
  bool regular = true;
  // Elimination with row exchanges, three columns at a time: first among themselves, then from
  // the rest.
  auto row_at = [&](int r) { return &jacobian_[(size_t)r * m3]; };
  for (int first = 0; first < m3 && regular; first += 3) {
    const int rest = first + 3;
    double* pivot[3];
    for (int k = 0; k < 3; k++) {
      const int c = first + k;
      int best = c;
      for (int r = c + 1; r < m3; r++)
        if (std::fabs(row_at(r)[c]) > std::fabs(row_at(best)[c])) best = r;
      pivot[k] = row_at(c);
      if (best != c) {
        std::swap_ranges(pivot[k] + first, pivot[k] + m3, row_at(best) + first);
        std::swap(x[best], x[c]);
      }
      for (int l = 0; l < k; l++)
        add_scaled(pivot[k] + rest, -pivot[k][first + l], pivot[l] + rest, m3 - rest);
      regular &= std::fabs(pivot[k][c]) > tune::kSingularPivot;
      const double inv = 1 / pivot[k][c];
      for (int r = c + 1; r < m3; r++) {
        double* row = row_at(r);
        const double f = row[c] *= inv;
        for (int d = c + 1; d < rest; d++) row[d] -= f * pivot[k][d];
        x[r] -= f * x[c];
      }
    }
    for (int r = rest; r < m3; r++) {
      double* row = row_at(r);
      add_scaled(row + rest, -row[first], pivot[0] + rest, -row[first + 1], pivot[1] + rest,
                 -row[first + 2], pivot[2] + rest, m3 - rest);
    }
  }
  if (regular) {
    for (int r = m3 - 1; r >= 0; r--) {
      const double* row = &jacobian_[(size_t)r * m3];
      double t = x[r];
      for (int d = r + 1; d < m3; d++) t -= row[d] * x[d];
      x[r] = t / row[r];
    }
    double share = 1;
    for (int attempt = 0; attempt < tune::kNewtonShares; attempt++, share *= 0.5) {
      for (int i = 0; i < 3 * n; i++) p[i] = (1 - share) * start_[i];
      for (int a = 0; a < m; a++)
        for (int r = 0; r < 3; r++)
          p[3 * set_[a] + r] = start_[3 * set_[a] + r] + share * x[3 * a + r];
      project();
      product();
      if (merit() < bound * (1 - tune::kNewtonDecrease)) return true;
    }
  }
  p = start_;
  product();
  return false;
}

// 0 <= p_n, A p_n + q >= 0, complementary, with friction held: block principal pivoting (Judice and
// Pires 1994), with single pivots where blocks cycle; the pivots are solved for by Cholesky.
void ContactProblem::normals(double tolerance) {
  const int n = size();
  q_.resize(n);
  x_.assign(n, 0);
  active_.resize(n);
  for (int i = 0; i < n; i++) {
    double s = beta[3 * i];
    for (int j = 0; j < n; j++) {
      const double* a = A(i, j);
      s += a[1] * p[3 * j + 1] + a[2] * p[3 * j + 2];
    }
    q_[i] = s;
    active_[i] = p[3 * i] > 0;
  }
  int fewest = n + 1, patience = tune::kBlockPivots;
  for (int it = 0; it < tune::kPivots; it++) {
    set_.clear();
    for (int i = 0; i < n; i++)
      if (active_[i]) set_.push_back(i);
    const int k = (int)set_.size();
    chol_.resize((size_t)k * k);
    for (int a = 0; a < k; a++) {
      double* row = &chol_[(size_t)a * k];
      for (int b = 0; b <= a; b++) {
        const double* other = &chol_[(size_t)b * k];
        double s = *A(set_[a], set_[b]);
        if (a == b) s *= 1 + tune::kCompliance;
        for (int c = 0; c < b; c++) s -= row[c] * other[c];
        row[b] = a == b ? std::sqrt(std::max(s, tune::kCholeskyPivot * *A(set_[a], set_[a]))) : s / other[b];
      }
    }
    x_.assign(n, 0);
    for (int a = 0; a < k; a++) {
      double s = -q_[set_[a]];
      for (int c = 0; c < a; c++) s -= chol_[(size_t)a * k + c] * x_[set_[c]];
      x_[set_[a]] = s / chol_[(size_t)a * (k + 1)];
    }
    for (int a = k - 1; a >= 0; a--) {
      double s = x_[set_[a]];
      for (int c = a + 1; c < k; c++) s -= chol_[(size_t)c * k + a] * x_[set_[c]];
      x_[set_[a]] = s / chol_[(size_t)a * (k + 1)];
    }
    int wrong = 0, last = -1;
    wrong_.assign(n, 0);
    // Redundant points trade rounding among themselves: that is no reason to pivot.
    double largest = 0;
    for (double x : x_) largest = std::max(largest, std::fabs(x));
    for (int i = 0; i < n; i++) {
      if (active_[i]) {
        wrong_[i] = x_[i] < -tune::kPull * largest;
      } else {
        double y = q_[i];
        for (int j : set_) y += *A(i, j) * x_[j];
        wrong_[i] = y < -tolerance;
      }
      if (wrong_[i]) wrong++, last = i;
    }
    if (wrong == 0) break;
    bool all = wrong < fewest || patience > 0;
    if (wrong < fewest)
      fewest = wrong, patience = tune::kBlockPivots;
    else
      patience--;
    for (int i = 0; i < n; i++)
      if (wrong_[i] && (all || i == last)) active_[i] = !active_[i];
  }
  for (int i = 0; i < n; i++) p[3 * i] = std::max(x_[i], 0.0);
}

void ContactProblem::solve(double tolerance, double fine, int most, SolveReport& report) {
  finish_groups();
  product();
  double least = 1e300;  // so far, and where
  auto judge = [&]() {
    report.residual = residual(false);
    if (report.residual < least) least = report.residual, best_ = p;
  };
  judge();
  double goal = fine, last = 1e300;
  // One sweep over one contact is exact: what rests feels nothing of where it started.
  if (size() == 1) goal = -1, most = 1;
  const int n_groups = (int)group_count_, sweeps = size() <= tune::kFewContacts ? tune::kRoundSweepsOfFew : tune::kRoundSweeps;
  int stalled = 0;
  for (int it = 0; it < most && report.residual >= goal;) {
    for (int sweep = 0; sweep < sweeps && it < most && report.residual >= goal; sweep++, it++) {
      for (int k = 0; k < n_groups; k++)
        settle(groups_[it % 2 == 0 ? k : n_groups - 1 - k], tune::kPairGoal * goal);
      report.sweeps++;
      judge();
    }
    double damping = tune::kNewtonDamping, recent[tune::kNewtonMemory];
    std::fill_n(recent, tune::kNewtonMemory, merit());
    int failures = 0;
    for (int step = 0; step < tune::kNewtonSteps && it < most && report.residual >= goal; step++, it++) {
      const bool better = newton(damping, *std::max_element(recent, recent + tune::kNewtonMemory));
      report.sweeps++;
      judge();
      if (better) {
        damping = std::max(tune::kNewtonLessDamping * damping, tune::kNewtonLeastDamping);
        recent[step % tune::kNewtonMemory] = merit();
      } else {
        damping *= tune::kNewtonMoreDamping;
        if (++failures == tune::kNewtonFailures) break;
      }
    }
    if (report.residual < tune::kRoundProgress * last)
      stalled = 0;
    else if (++stalled == tune::kStalledRounds)
      break;
    last = std::min(last, report.residual);
    // What must be finer than the tolerance is given half of the sweeps for it.
    if (it >= (fine < tolerance ? most / 2 : tune::kFinePatience)) goal = tolerance;
    if (it >= tune::kTolerancePatience && fine >= tolerance) goal = tune::kEnough * tolerance;
  }
  if (report.residual > least) p = best_, product();
  report.residual = residual(false);
  report.normal = residual(true);
  // Where friction is slow to settle it is held and the normal impulses are solved for alone:
  // nothing penetrates, and the next substep starts warm.
  if (report.residual < tolerance || report.normal < tune::kEnough * tolerance) return;
  best_ = p;  // pivots that do not end must not count
  const double work = std::pow((double)size(), 3) * tune::kPivots / 6;  // of a round, at most
  for (int r = 0; r < tune::kNormalRounds && report.normal >= tolerance && r * work <= tune::kNormalWork; r++) {
    normals(tune::kNormalGoal * tolerance);
    if (r >= tune::kFrictionRounds)
      for (int i = 0; i < size(); i++)
        if (std::hypot(p[3 * i + 1], p[3 * i + 2]) > local_[i].mu * p[3 * i] + tune::kConeRounding)
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

}  // namespace hp
