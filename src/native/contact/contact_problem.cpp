#include "contact/contact_problem.h"

#include <cmath>

#include "math/simd.h"
#include "tuning.h"

namespace hp {

namespace tune = tuning::contact;

void ContactProblem::clear(double most_work) {
  A.clear();
  budget.begin(most_work);
  beta.clear();
  p.clear();
  local_.clear();
  normals_.clear();
  group_count_ = 0;
}

void ContactProblem::add(const double* beta3, const double* warm3, double mu, int pair) {
  const int n = size();
  double* a = A.block(n, n);
  double floor = tune::kDiagonalShare *
                 std::max(a[0], tune::kLeastInverseMass);  // of a contact between immovable bodies
  Mat3 B;
  for (int q = 0; q < 3; q++) a[q * (A.stride() + 1)] += floor;
  for (int q = 0; q < 9; q++) B.m[q] = a[(q / 3) * A.stride() + q % 3];
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
    groups_[g].delassus.clear();
  }
  groups_[g].rows.push_back(n);
}

void ContactProblem::finish_groups() {
  for (size_t i = 0; i < group_count_; i++) {
    Group& g = groups_[i];
    size_t m = g.rows.size();
    if (g.delassus.size() == 9 * m * m) continue;
    g.delassus.resize(9 * m * m);
    for (size_t a = 0; a < m; a++)
      for (size_t b = 0; b < m; b++)
        for (int r = 0; r < 3; r++)
          for (int c = 0; c < 3; c++)
            g.delassus[(3 * a + r) * 3 * m + 3 * b + c] =
                A.block(g.rows[a], g.rows[b])[r * A.stride() + c];
  }
}

void ContactProblem::product() {
  const int n3 = 3 * size();
  w_ = beta;
  double* w = w_.data();
  for (int i = 0; i < n3; i++) {
    double f = p[i];
    if (f == 0) continue;
    add_scaled(w, f, A.row(i), n3);
  }
  budget.spend(tune::kProductWork * n3 * n3);
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

// Sweeps over the contacts of one pair alone; then the velocities of all contacts follow.
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
      change =
          std::max(change, std::max(std::fabs(d.x) * c.A.m[0],
                                    std::max(std::fabs(d.y), std::fabs(d.z)) / c.tangent_step));
      const double *r0 = &g.delassus[(size_t)3 * a * m3], *r1 = r0 + m3, *r2 = r1 + m3;
      double* own = own_.data();
      for (int j = 0; j < m3; j++) own[j] += d.x * r0[j] + d.y * r1[j] + d.z * r2[j];
    }
    budget.spend(m3 * m3 + tune::kContactWork * m);
    if (m == 1 || change < tolerance) break;
  }
  const int n3 = 3 * size();
  budget.spend(m3 * n3);
  double* w = w_.data();
  for (int a = 0; a < m; a++) {
    int i = g.rows[a];
    double d0 = p[3 * i] - old_[3 * a], d1 = p[3 * i + 1] - old_[3 * a + 1],
           d2 = p[3 * i + 2] - old_[3 * a + 2];
    if (d0 == 0 && d1 == 0 && d2 == 0) continue;
    const double *r0 = A.row(3 * i), *r1 = A.row(3 * i + 1), *r2 = A.row(3 * i + 2);
    add_scaled(w, d0, r0, d1, r1, d2, r2, n3);
  }
}

void ContactProblem::judge(Progress& at, SolveReport& report) {
  budget.spend(tune::kContactWork * size());
  report.residual = residual(false);
  if (report.residual < at.least) at.least = report.residual, best_ = p;
}

void ContactProblem::sweep_round(Progress& at, SolveReport& report) {
  const int n_groups = (int)group_count_;
  const int sweeps = size() <= tune::kFewContacts ? tune::kRoundSweepsOfFew : tune::kRoundSweeps;
  for (int sweep = 0; sweep < sweeps && at.goes_on(report.residual); sweep++, at.done++) {
    for (int k = 0; k < n_groups; k++)
      settle(groups_[at.done % 2 == 0 ? k : n_groups - 1 - k], tune::kPairGoal * at.goal);
    report.sweeps++;
    judge(at, report);
  }
}

void ContactProblem::newton_round(Progress& at, SolveReport& report) {
  double damping = tune::kNewtonDamping, recent[tune::kNewtonMemory];
  std::fill_n(recent, tune::kNewtonMemory, merit());
  int failures = 0;
  for (int step = 0; step < tune::kNewtonSteps && at.goes_on(report.residual); step++, at.done++) {
    const bool better =
        newton_step(damping, *std::max_element(recent, recent + tune::kNewtonMemory));
    report.sweeps++;
    judge(at, report);
    if (better) {
      damping = std::max(tune::kNewtonLessDamping * damping, tune::kNewtonLeastDamping);
      recent[step % tune::kNewtonMemory] = merit();
    } else {
      damping *= tune::kNewtonMoreDamping;
      if (++failures == tune::kNewtonFailures) break;
    }
  }
}

// Rounds of sweeps and Newton steps from p on; p is then the best that they met.
void ContactProblem::iterate(double tolerance, double fine, int most, SolveReport& report) {
  product();
  Progress at{fine, 0, most, 1e300, budget};
  judge(at, report);
  // One sweep over one contact is exact: what rests feels nothing of where it started.
  if (size() == 1) at.goal = -1, at.most = 1;
  const bool rests = fine < tune::kSettleGoal * tolerance;
  int stalled = 0;
  double last = 1e300;
  const int all = at.most;
  if (size() > 1 && size() <= tune::kEvenContacts && !rests && at.goes_on(report.residual)) {
    // Newton steps take left and right alike, sweeps take the first contacts first. Steps that do not reach the
    // tolerance are undone.
    const std::vector<double> before = p;
    at.most = std::min(all, tune::kFinePatience);
    newton_round(at, report);
    at.most = all;
    if (report.residual >= tolerance) {
      p = before, at.done = 0;
      product();
      judge(at, report);
    }
  }
  while (at.goes_on(report.residual)) {
    if (!rests && at.goal < tolerance) at.most = std::min(all, tune::kFinePatience);
    sweep_round(at, report);
    newton_round(at, report);
    at.most = all;
    if (report.residual < tune::kRoundProgress * last)
      stalled = 0;
    else if (++stalled == tune::kStalledRounds)
      break;
    last = std::min(last, report.residual);
    // What must not creep is given half of the sweeps to be fine.
    if (at.done >= (rests ? all / 2 : tune::kFinePatience)) at.goal = tolerance;
    if (at.done >= tune::kTolerancePatience && !rests) at.goal = tune::kEnough * tolerance;
  }
  if (report.residual > at.least) p = best_, product();
  report.residual = residual(false);
  report.normal = residual(true);
}

// Other ways to an answer where rounds from the warm start do not end: rounds from nothing, then a
// path through smoothed problems. What does not end is no better: p is then as it was.
void ContactProblem::start_anew(double tolerance, int most, SolveReport& report) {
  const std::vector<double> before = p;
  const double residual_before = report.residual, normal_before = report.normal;
  std::fill(p.begin(), p.end(), 0.0);
  iterate(tolerance, tolerance, most, report);
  if (report.residual >= tune::kEnough * tolerance) {
    const bool better = path_.follow(A, beta, local_, tolerance, report.residual, budget, p);
    report.sweeps += path_.steps();
    if (better) {
      project();
      product();
      report.residual = residual(false);
      report.normal = residual(true);
    }
  }
  if (report.residual < tune::kEnough * tolerance) return;
  p = before;
  product();
  report.residual = residual_before;
  report.normal = normal_before;
}

void ContactProblem::solve(double tolerance, double fine, int most, SolveReport& report) {
  const double before = budget.work(), enough = tune::kEnough * tolerance;
  barred_ = false;
  finish_groups();
  iterate(tolerance, fine, most, report);
  if (report.residual >= enough && settles && size() > 1) start_anew(tolerance, most, report);
  if (report.residual >= tolerance && report.normal >= enough) settle_normals(tolerance, report);
  if (report.residual >= (settles ? std::max(enough, tune::kDrivingSlip) : enough))
    drop_driving_friction(tolerance, report);
  report.friction = 0;
  for (int i = 0; i < size(); i++)
    report.friction = std::max(report.friction, local_[i].friction_residual(&p[3 * i], &w_[3 * i]));
  report.exhausted = report.residual >= tolerance && (barred_ || !budget.affords(0));
  report.work += budget.work() - before;
}

}  // namespace hp
