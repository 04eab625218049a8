// What the drive itself exerts: limits of it, and how much it was.
//
// A substep solves M^ (v - v*) = J^T p with M^ = s (M + X). Of what changes the deviation e = v - v_ref
// of a body of inertia M, the contacts' impulse is the one part; the rest is the drive's:
//
//   h tau = M (e - e_before) - M^ (v - v*)
//
// It is zero in free motion, and what balances the contacts in a static hold. What held things ask for
// (holding.cpp) is added: it is no part of e.
#include "stepping/stepper.h"

namespace hp {

namespace {

// Share of what it can that a drive pulls with by itself: the rest is for what holds the body to move.
constexpr double kPull = 0.97;
// Joints that give in are to exert this share of what they can; rounds of that, then all do.
constexpr double kAim = 0.9;
constexpr int kRounds = 6;
constexpr double kRest = 1e-9;  // smaller changes of velocity are rounding [m/s, rad/s]
constexpr double kFaint = 1e-9;  // and smaller impulses [N s, N m s]

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

void Drive::exert(const double* impulse) {
  if (!exerted_) std::fill(impulse_.begin(), impulse_.end(), 0.0);
  exerted_ = true;
  for (int i = 0; i < nv_; i++) impulse_[i] += impulse[dof0_ + i];
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

// Cuts what the drive exerts to what its joints can; true if any could not.
bool Stepper::cut(const Drive& d, double h, double* impulse) const {
  bool any = false;
  for (int k = 0; k <= d.ball_count(); k++) any |= cap(d, k, kPull * h * d.limits[k], impulse);
  return any;
}

// The drive pulls the deviation e back by D in a substep, v* = v_ref + e - D, and against what holds
// the body with M^ D. Neither any joint's own share of it, M^_jj |D_j|, nor what the joints' coupling
// makes of it may exceed what the joint can. (M D, where nothing holds it: holding.cpp.) Where nothing is
// cut v* stays as it is, bit for bit.
void Stepper::limit_strength(double h) {
  for (const Drive& d : drives_) {
    if (d.limits.empty() || !world.active[d.body(0)] || d.gentle()) continue;
    d.unhindered(change_.data());
    const int first = d.first_dof(), end = first + d.dof_count();
    for (int i = first; i < end; i++) change_[i] -= v_free_[i];
    if (largest(d, change_.data()) < kRest) continue;
    build_inertia(h);
    const double s = d.scale(drive_settings, h);
    bool less = false;
    for (int k = 0; k <= d.ball_count(); k++) {
      const int at = first_of(d, k);
      double own = 0;
      for (int c = 0; c < 3; c++) own += s * (inertia_.diagonal(model, at + c) + resist_[at + c]) / 3;
      less |= cap(d, k, kPull * h * d.limits[k] / own, change_.data());
    }
    std::fill(pushed_.begin(), pushed_.end(), 0.0);
    weigh(d, change_.data(), pushed_.data());
    for (int i = first; i < end; i++) pushed_[i] = s * (pushed_[i] + resist_[i] * change_[i]);
    if (cut(d, h, pushed_.data())) {
      inertia_.solve(model, pushed_.data());
      std::copy(pushed_.begin() + first, pushed_.begin() + end, change_.begin() + first);
      less = true;
    }
    if (!less) continue;
    d.unhindered(v_free_.data());
    for (int i = first; i < end; i++) v_free_[i] -= change_[i];
  }
}

// out = X x, what the drive adds to the inertia of the joints, less where they give in (share_):
// X = share (M^ - M) share.
void Stepper::added(const Drive& d, double h, const double* x, double* out) {
  const int first = d.first_dof(), end = first + d.dof_count();
  const double s = d.scale(drive_settings, h);
  for (int i = first; i < end; i++) softer_[i] = share_[i] * x[i];
  weigh(d, softer_.data(), out);
  for (int i = first; i < end; i++)
    out[i] = share_[i] * ((s - 1) * out[i] + s * stiff_[i] * softer_[i]);
}

// The impulse that a drive exerts in a substep that ends with the velocities v, into exerted_; false if it
// is none.
bool Stepper::exertion(const Drive& d, const double* v, double h) {
  const int first = d.first_dof(), end = first + d.dof_count();
  d.deviation_change(v, change_.data());
  for (int i = first; i < end; i++) pushed_[i] = v[i] - v_star_[i];
  const bool touched = largest(d, pushed_.data()) > 0;
  const bool changes = touched || largest(d, change_.data()) >= kRest;
  const bool own = drive_settings.own_forces();
  if (!changes && !carries(d) && !own) return false;
  const bool overcome = overcome_[&d - drives_.data()] > 0;
  const double s = touched && !overcome ? d.scale(drive_settings, h) : 1;
  std::fill(exerted_.begin() + first, exerted_.begin() + end, 0.0);
  if (changes) {
    if (!inertia_ready_) {
      start_.kin.update_dofs(model, qpos_.data(), world.active.data());
      inertia_.compose(model, start_.kin, world.active.data());
    }
    for (int i = first; touched && i < end; i++) change_[i] -= s * pushed_[i];
    weigh(d, change_.data(), exerted_.data());
  }
  for (int i = first; carries(d) && i < end; i++) exerted_[i] += h * load_[i];
  if (own) discount_own(d, v, h);
  if (!touched) return true;
  if (overcome) added(d, h, pushed_.data(), change_.data());
  for (int i = first; i < end; i++)
    exerted_[i] -= overcome ? change_[i] : s * resist_[i] * pushed_[i];
  return true;
}

// M^ = M + X is heavier than the body, and what hits it is met with X (v* - v) beyond the pull,
// M (v* - v_ref - e), and what is held, which are within the limits. A joint that would exert more than it
// can, in the step that was tried, resists less: X becomes share X share. True if there is such a joint: the
// step is to be tried again. Where that goes on, or the step would have to be made in pieces, nothing but the
// pull is left.
bool Stepper::give_in(double h) {
  bool any = false;
  for (size_t p = 0; p < drives_.size(); p++) {
    const Drive& d = drives_[p];
    if (d.limits.empty() || overcome_[p] > kRounds || !world.active[d.body(0)] || d.gentle()) continue;
    if (!exertion(d, v_.data(), h)) continue;
    if (largest(d, pushed_.data()) == 0) continue;  // nothing is met
    const int first = d.first_dof(), end = first + d.dof_count();
    bool over = !good_, none = !good_ || overcome_[p] == kRounds;
    d.unhindered(pushed_.data());
    for (int i = first; i < end; i++) pushed_[i] = v_star_[i] - pushed_[i];
    weigh(d, pushed_.data(), change_.data());
    if (carries(d))
      for (int i = first; i < end; i++) change_[i] += h * load_[i];
    if (overcome_[p] == 0) std::copy_n(resist_.begin() + first, end - first, stiff_.begin() + first);
    for (int k = 0; k <= d.ball_count(); k++) {
      const int at = first_of(d, k);
      const double most = h * d.limits[k];
      const Vec3 pull = load3(&change_[at]), all = load3(&exerted_[at]);
      if (norm(all) <= most + kFaint) continue;
      over = true;
      const double room = std::max(0.0, kAim * most - norm(pull)), more = norm(all - pull);
      for (int c = 0; c < 3 && more > room; c++) share_[at + c] *= room / more;
    }
    if (!over) continue;
    if (holds_[p]) {  // first without
      holds_[p] = 0, any = true;
      std::fill_n(share_.begin() + first, end - first, 1.0);
      continue;
    }
    if (none) std::fill_n(share_.begin() + first, end - first, 0.0);
    overcome_[p] = none ? kRounds + 1 : overcome_[p] + 1;
    any = true;
  }
  if (any) inertia_ready_ = false;
  if (any && keep_trace) trace.overcome.insert(trace.overcome.end(), v_.begin(), v_.end());
  return any;
}

// Adds up what the drives exerted in a substep that has ended with qvel_.
void Stepper::tally(double h) {
  for (Drive& d : drives_) {
    if (!world.active[d.body(0)]) continue;
    if (exertion(d, qvel_.data(), h)) d.exert(exerted_.data());
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
