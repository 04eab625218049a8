#include "stepping/strength.h"

#include "stepping/layer_load.h"
#include "tuning.h"

namespace hp {

namespace tune = tuning::stepping;

namespace {

// Scales `count` entries to a norm of at most `most`; true if it was more.
bool cap(double* x, int count, double most) {
  double size = 0;
  for (int c = 0; c < count; c++) size += x[c] * x[c];
  size = std::sqrt(size);
  if (size <= most) return false;
  for (int c = 0; c < count; c++) x[c] *= most / size;
  return true;
}

// Scales the entries of x [nv] that limit k is of to at most so many times the limit; true if they were
// more. x is what the drive takes off in M^ = s (M + ...): the opposite of what it exerts.
bool cap(const Drive& d, int k, double times, double s, double* x) {
  double* at = x + d.limit_dof(k);
  if (k > 0 || !d.root_force.on) return cap(at, 3, times * d.limits[k]);
  const bool across = cap(at, 2, times * d.root_force.across);
  const double pull = d.root_force.upright(-at[2]);
  return cap(at + 2, 1, times * (d.root_force.falls ? s * pull : pull)) || across;
}

double largest(const Drive& d, const double* x) {
  double most = 0;
  for (int i = d.first_dof(); i < d.first_dof() + d.dof_count(); i++)
    most = std::max(most, std::fabs(x[i]));
  return most;
}

// Cuts what the drive exerts to what its joints can; true if any exceeded that.
bool cut(const Drive& d, double h, double s, double* impulse) {
  bool any = false;
  for (int k = 0; k <= d.ball_count(); k++) any |= cap(d, k, tune::kPullShare * h, s, impulse);
  return any;
}

}  // namespace

void StrengthLimits::finish(const Model& m) {
  for (auto* v : {&exerted_, &change_, &pushed_, &stiff_, &softer_, &kept_}) v->assign(m.nv, 0);
}

void StrengthLimits::begin(const System& system, const Step& step) {
  v_star_ = step.v_free;
  in_pieces_.assign(system.drives.size(), 0);
}

void StrengthLimits::keep(const System& system, Data& data, const std::vector<double>& share) {
  for (size_t p = 0; p < system.drives.size(); p++) {
    const Drive& d = system.drives[p];
    const int first = d.first_dof(), count = d.dof_count();
    if (!system.active(d) || d.gentle() || share[d.body(0)] < 0) continue;
    if (!exertion(system, data, p, data.step.v, data.step.length))
      std::fill_n(exerted_.begin() + first, count, 0.0);
    std::copy_n(exerted_.begin() + first, count, kept_.begin() + first);
    std::copy_n(data.step.v.begin() + first, count, v_star_.begin() + first);
    in_pieces_[p] = 1;
  }
  data.step.braced.clear();  // it is in what was kept
}

// The drive pulls the deviation e back by D in a substep, v* = v_ref + e - D, and against what
// holds the body with M^ D.
void StrengthLimits::limit(const System& system, Data& data, double h) {
  EffectiveInertia& inertia = data.inertia;
  std::vector<double>& v_free = data.step.v_free;
  for (const Drive& d : system.drives) {
    if (d.limits.empty() || !system.active(d) || d.gentle()) continue;
    d.unhindered(change_.data());
    const int first = d.first_dof(), end = first + d.dof_count();
    for (int i = first; i < end; i++) change_[i] -= v_free[i];
    if (largest(d, change_.data()) < tune::kVelocityRounding) continue;
    inertia.add_up(system, data.state, data.step, h);
    const std::vector<double>& added = inertia.added();
    const double s = d.scale(system.drive_settings, h);
    bool less = false;
    for (int k = 0; k <= d.ball_count(); k++) {
      const int at = d.limit_dof(k);
      double own = 0;
      for (int c = 0; c < 3; c++)
        own += s * (inertia.inertia().diagonal(at + c) + added[at + c]) / 3;
      less |= cap(d, k, tune::kPullShare * h / own, s, change_.data());
    }
    std::fill(pushed_.begin(), pushed_.end(), 0.0);
    inertia.multiply(system, d, change_.data(), pushed_.data());
    for (int i = first; i < end; i++) pushed_[i] = s * (pushed_[i] + added[i] * change_[i]);
    if (cut(d, h, s, pushed_.data())) {
      inertia.build(system, data.state, data.step, h);
      inertia.solve(system.model, pushed_.data());
      std::copy(pushed_.begin() + first, pushed_.begin() + end, change_.begin() + first);
      less = true;
    }
    if (!less) continue;
    d.unhindered(v_free.data());
    for (int i = first; i < end; i++) v_free[i] -= change_[i];
  }
}

// out = theta (M^ - M) theta x: what the drive adds to the inertia of the joints, less where they
// give in.
void StrengthLimits::added(const System& system, const Data& data, const Drive& d, double h,
                           const double* x, double* out) {
  const std::vector<double>& share = data.step.resistance.share;
  const int first = d.first_dof(), end = first + d.dof_count();
  const double s = d.scale(system.drive_settings, h);
  for (int i = first; i < end; i++) softer_[i] = share[i] * x[i];
  data.inertia.multiply(system, d, softer_.data(), out);
  for (int i = first; i < end; i++)
    out[i] = share[i] * ((s - 1) * out[i] + s * stiff_[i] * softer_[i]);
}

// The same of pushed_ for the joints as they are now, into change_.
void StrengthLimits::resist(const System& system, Data& data, size_t person, double h) {
  const Drive& d = system.drives[person];
  const int first = d.first_dof(), end = first + d.dof_count();
  data.inertia.compose(system, data.state);
  if (data.step.resistance.rounds[person] > 0)
    return added(system, data, d, h, pushed_.data(), change_.data());
  const double s = d.scale(system.drive_settings, h);
  data.inertia.multiply(system, d, pushed_.data(), change_.data());
  for (int i = first; i < end; i++)
    change_[i] = (s - 1) * change_[i] + s * data.inertia.added()[i] * pushed_[i];
}

// The impulse that a drive exerts in a substep that ends with the velocities v, into exerted_;
// false if it is none. Leaves v - v* in pushed_. After a piece: what it has exerted by then, and what
// resists contacts since.
bool StrengthLimits::exertion(const System& system, Data& data, size_t person,
                              const std::vector<double>& v, double h) {
  const Drive& d = system.drives[person];
  const int first = d.first_dof(), end = first + d.dof_count();
  for (int i = first; i < end; i++) pushed_[i] = v[i] - v_star_[i];
  const bool touched = largest(d, pushed_.data()) > 0;
  if (in_pieces_[person]) {
    if (touched) resist(system, data, person, h);
    for (int i = first; i < end; i++) exerted_[i] = kept_[i] - (touched ? change_[i] : 0);
    if (touched) add_braced(d, data.step);
    return true;
  }
  d.deviation_change(v.data(), change_.data());
  const bool changes = touched || largest(d, change_.data()) >= tune::kVelocityRounding;
  const bool own = system.drive_settings.own_forces();
  if (!changes && !system.carries(d) && !own) return false;
  const bool overcome = data.step.resistance.rounds[person] > 0;
  const double s = touched && !overcome ? d.scale(system.drive_settings, h) : 1;
  std::fill(exerted_.begin() + first, exerted_.begin() + end, 0.0);
  if (changes) {
    data.inertia.compose(system, data.state);
    for (int i = first; touched && i < end; i++) change_[i] -= s * pushed_[i];
    // Its own weight is no force of the drive.
    change_[first + 2] += d.scale(system.drive_settings, h) * layer_fall(system, d, h);
    data.inertia.multiply(system, d, change_.data(), exerted_.data());
  }
  for (int i = first; system.carries(d) && i < end; i++) exerted_[i] += h * load_.force()[i];
  if (own) internal_.discount(system, d, v.data(), h, exerted_.data());
  if (!touched) return true;
  if (overcome) added(system, data, d, h, pushed_.data(), change_.data());
  for (int i = first; i < end; i++)
    exerted_[i] -= overcome ? change_[i] : s * data.inertia.added()[i] * pushed_[i];
  add_braced(d, data.step);
  return true;
}

void StrengthLimits::add_braced(const Drive& d, const Step& step) {
  if (step.braced.empty()) return;
  for (int i = d.first_dof(); i < d.first_dof() + d.dof_count(); i++) exerted_[i] += step.braced[i];
}

// Reduces theta of `count` dofs whose drive exerts more than `most`; true if it does.
bool StrengthLimits::less(int at, int count, double most, JointResistance& resistance) const {
  double all = 0, pull = 0, more = 0;
  for (int i = at; i < at + count; i++) {
    all += exerted_[i] * exerted_[i], pull += change_[i] * change_[i];
    more += (exerted_[i] - change_[i]) * (exerted_[i] - change_[i]);
  }
  if (std::sqrt(all) <= most + tune::kImpulseRounding) return false;
  const double room = std::max(0.0, tune::kResistShare * most - std::sqrt(pull));
  more = std::sqrt(more);
  for (int i = at; i < at + count && more > room; i++) resistance.share[i] *= room / more;
  return true;
}

// Reduces theta of the joints that exceed their strength; true if there are any. The pull
// M (v* - v_ref - e) and what is held are within the limits: the rest is what may resist.
bool StrengthLimits::share_out(const System& system, Data& data, size_t person, double h) {
  const Drive& d = system.drives[person];
  JointResistance& resistance = data.step.resistance;
  const int first = d.first_dof(), end = first + d.dof_count();
  if (in_pieces_[person]) {
    std::copy_n(kept_.begin() + first, end - first, change_.begin() + first);
  } else {
    d.unhindered(pushed_.data());
    for (int i = first; i < end; i++) pushed_[i] = v_star_[i] - pushed_[i];
    pushed_[first + 2] += layer_fall(system, d, h);
    data.inertia.multiply(system, d, pushed_.data(), change_.data());
    if (system.carries(d))
      for (int i = first; i < end; i++) change_[i] += h * load_.force()[i];
  }
  if (resistance.rounds[person] == 0)
    std::copy_n(data.inertia.added().begin() + first, end - first, stiff_.begin() + first);
  bool over = false;
  for (int k = 0; k <= d.ball_count(); k++) {
    const int at = d.limit_dof(k);
    if (k > 0 || !d.root_force.on) {
      over |= less(at, 3, h * d.limits[k], resistance);
      continue;
    }
    over |= less(at, 2, h * d.root_force.across, resistance);
    over |= less(at + 2, 1, h * d.root_force.upright(exerted_[at + 2]), resistance);
  }
  return over;
}

bool StrengthLimits::give_in(System& system, Data& data, double h) {
  JointResistance& r = data.step.resistance;
  bool any = false;
  for (size_t p = 0; p < system.drives.size(); p++) {
    const Drive& d = system.drives[p];
    if (d.limits.empty() || r.rounds[p] > tune::kResistRounds || !system.active(d) || d.gentle())
      continue;
    if (!exertion(system, data, p, data.step.v, h)) continue;
    if (largest(d, pushed_.data()) == 0) continue;  // no contact acts on it
    const int first = d.first_dof(), count = d.dof_count();
    const bool good = data.attempt.settled(data.islands.of_tree(d.body(0)));
    const bool out = data.spent(data.islands.of_tree(d.body(0)));
    const bool none = !good || out || r.rounds[p] == tune::kResistRounds;
    if (!share_out(system, data, p, h) && good) continue;
    any = true;
    if (r.holds[p]) {  // first without holding what nothing touches
      r.holds[p] = 0;
      std::fill_n(r.share.begin() + first, count, 1.0);
      if (!out) continue;
    }
    if (none) std::fill_n(r.share.begin() + first, count, 0.0);
    r.rounds[p] = none ? tune::kResistRounds + 1 : r.rounds[p] + 1;
  }
  if (any) data.inertia.refactor();
  Probe& probe = data.probe;
  if (any && probe.tracing)
    probe.trace.overcome.insert(probe.trace.overcome.end(), data.step.v.begin(), data.step.v.end());
  return any;
}

void StrengthLimits::tally(System& system, Data& data, double h) {
  for (size_t p = 0; p < system.drives.size(); p++) {
    Drive& d = system.drives[p];
    if (system.active(d) && exertion(system, data, p, data.state.qvel, h))
      d.effort.add(exerted_.data() + d.first_dof());
  }
}

}  // namespace hp
