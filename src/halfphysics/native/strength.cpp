// What the drive itself exerts: limits of it, and how much it was.
//
// A substep solves M^ (v - v*) = J^T p with M^ = s (M + X). Of what changes the deviation e = v - v_ref
// of a body of inertia M, the contacts' impulse is the one part; the rest is the drive's:
//
//   h tau = M (e - e_before) - M^ (v - v*)
//
// It is zero in free motion, and what balances the contacts in a static hold. What held things ask for
// (holding.cpp) is added: it is no part of e.
#include "stepper.h"

namespace hp {

namespace {

constexpr double kRest = 1e-9;  // smaller changes of velocity are rounding [m/s, rad/s]

int first_of(const Drive& d, int limit) { return d.limit_dof(limit); }

// Scales the limit's three entries of x (nv of the model) to at most `most`; true if they were more.
bool cap(const Drive& d, int limit, double most, double* x) {
  double* at = x + first_of(d, limit);
  const double size = norm(load3(at));
  if (size <= most) return false;
  for (int c = 0; c < 3; c++) at[c] *= most / size;
  return true;
}

double largest(const Drive& d, const double* x) {
  double most = 0;
  for (int i = d.first_dof(); i < d.first_dof() + d.dof_count(); i++)
    most = std::max(most, std::fabs(x[i]));
  return most;
}

}  // namespace

void Drive::set_stiffness(const double* lambda) {
  stiffness_.assign(lambda, lambda + balls_.size());
}

void Drive::deviation_change(const double* qvel, double* change) const {
  for (int i = 0; i < nv_; i++) change[dof0_ + i] = qvel[dof0_ + i] - v_ref_[i] - deviation_[i];
}

void Drive::unhindered(double* v) const {
  for (int i = 0; i < nv_; i++) v[dof0_ + i] = v_ref_[i] + deviation_[i];
}

double Drive::allowance(int limit, double h) const {
  return std::max(0.0, h * limits[limit] - debt_[limit]);
}

void Drive::exert(const double* impulse, double h) {
  if (!exerted_) std::fill(impulse_.begin(), impulse_.end(), 0.0);
  exerted_ = true;
  for (int i = 0; i < nv_; i++) impulse_[i] += impulse[dof0_ + i];
  for (size_t i = 0; i < limits.size(); i++) {
    const double size = norm(load3(impulse + first_of(*this, (int)i)));
    debt_[i] = std::max(0.0, debt_[i] + size - h * limits[i]);
  }
}

std::vector<double> Drive::force() const {
  if (!exerted_) return {};
  std::vector<double> out(impulse_);
  for (double& f : out) f /= dt_;
  return out;
}

void Stepper::weigh(const Drive& d, const double* x, double* out) const {
  inertia_.multiply(model, d.body(0), model.dof_body[d.first_dof() + d.dof_count() - 1], x, out);
}

// The drive pulls the deviation e back by D in a substep, v* = v_ref + e - D, and against what holds
// the body with M^ D. Neither any joint's own share of it, M^_jj |D_j|, nor what the joints' coupling
// makes of it may exceed the joint's allowance. Where nothing is capped v* stays as it is, bit for bit.
void Stepper::limit_strength(double h) {
  for (const Drive& d : drives_) {
    if (d.limits.empty() || !world.active[d.body(0)] || d.gentle()) continue;
    d.unhindered(change_.data());
    const int first = d.first_dof(), end = first + d.dof_count();
    for (int i = first; i < end; i++) change_[i] -= v_free_[i];
    if (largest(d, change_.data()) < kRest) continue;
    build_inertia(h);
    const double s = d.scale(drive_settings, h);
    bool capped = false;
    for (int k = 0; k <= d.ball_count(); k++) {
      const int at = first_of(d, k);
      double own = 0;
      for (int c = 0; c < 3; c++) own += s * (inertia_.diagonal(model, at + c) + resist_[at + c]) / 3;
      capped |= cap(d, k, d.allowance(k, h) / own, change_.data());
    }
    std::fill(pushed_.begin(), pushed_.end(), 0.0);
    weigh(d, change_.data(), pushed_.data());
    for (int i = first; i < end; i++) pushed_[i] = s * (pushed_[i] + resist_[i] * change_[i]);
    bool coupled = false;
    for (int k = 0; k <= d.ball_count(); k++)
      coupled |= cap(d, k, d.allowance(k, h), pushed_.data());
    if (coupled) {
      inertia_.solve(model, pushed_.data());
      std::copy(pushed_.begin() + first, pushed_.begin() + end, change_.begin() + first);
    }
    if (!capped && !coupled) continue;
    d.unhindered(v_free_.data());
    for (int i = first; i < end; i++) v_free_[i] -= change_[i];
  }
}

// Adds up what the drives exerted in a substep that has ended with qvel_.
void Stepper::tally(double h) {
  bool known = inertia_ready_;
  for (Drive& d : drives_) {
    if (!world.active[d.body(0)]) continue;
    d.deviation_change(qvel_.data(), change_.data());
    const int first = d.first_dof(), end = first + d.dof_count();
    for (int i = first; i < end; i++) pushed_[i] = qvel_[i] - v_star_[i];
    const bool touched = largest(d, pushed_.data()) > 0;
    if (!touched && largest(d, change_.data()) < kRest) {
      if (!carries(d)) continue;
      for (int i = first; i < end; i++) exerted_[i] = h * load_[i];
      d.exert(exerted_.data(), h);
      continue;
    }
    if (!known) {
      start_.kin.update_dofs(model, qpos_.data(), world.active.data());
      inertia_.compose(model, start_.kin, world.active.data());
      known = true;
    }
    // M^ (v - v*) is s M (v - v*) and what the drive adds to M: one product with M for both terms.
    const double s = touched ? d.scale(drive_settings, h) : 0;
    for (int i = first; i < end; i++) change_[i] -= s * pushed_[i];
    weigh(d, change_.data(), exerted_.data());
    for (int i = first; i < end; i++) exerted_[i] -= s * resist_[i] * pushed_[i];
    if (carries(d))
      for (int i = first; i < end; i++) exerted_[i] += h * load_[i];
    d.exert(exerted_.data(), h);
  }
}

int Stepper::ball_count() const {
  int n = 0;
  for (const Drive& d : drives_) n += d.ball_count();
  return n;
}

bool Stepper::torques(std::vector<double>& out) const {
  bool any = false;
  for (const Drive& d : drives_) any |= d.exerts();
  if (!any) return false;
  for (const Drive& d : drives_) {
    const std::vector<double> force = d.force();
    for (int b = 0; b < d.ball_count(); b++)
      for (int c = 0; c < 3; c++)
        out.push_back(force.empty() ? 0.0 : force[d.ball_dof(b) - d.first_dof() + c]);
  }
  return true;
}

}  // namespace hp
