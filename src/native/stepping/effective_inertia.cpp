#include "stepping/effective_inertia.h"

#include <algorithm>

#include "stepping/data.h"
#include "tuning.h"

namespace hp {

namespace tune = tuning::stepping;

void JointResistance::finish(const Model& m, size_t drives) {
  touched.assign(m.nbody, 0);
  holds.assign(drives, 1);
  rounds.assign(drives, 0);
  share.assign(m.nv, 1);
}

void JointResistance::begin(const Model& m, size_t drives) {
  touched.assign(m.nbody, 1);
  rounds.assign(drives, 0);
  holds.assign(drives, 1);
  share.assign(m.nv, 1);
}

void EffectiveInertia::finish(const Model& m) {
  for (auto* v : {&drive_, &total_, &added_}) v->assign(m.nv, 0);
  scale_.assign(m.nv, 1);
}

void EffectiveInertia::add_up(const System& system, const State& state, const Step& step,
                              double h) {
  if (composed_ && added_up_) return;
  const World& world = system.world;
  if (!composed_) {
    inertia_.compose(system.model, state.pose.kin, world.active.data());
    drop_products();
  }
  add_drives(system, step.resistance, h);
  system.articulations.added_inertia(system.model, world.active, h, drive_);
  total_ = drive_;
  const std::vector<double>& damping = step.resistance.damping;
  for (size_t i = 0; i < damping.size(); i++) total_[i] += h * damping[i];
  hold_untouched(system, step.resistance);
  stiffen_exits(system, state);
  if (system.drive_settings.joint_damping > 0) damp_joints(system, h);
  for (const Drive& d : system.drives)  // inactive people keep what is known of them
    if (system.active(d))
      std::copy_n(total_.begin() + d.first_dof(), d.dof_count(), added_.begin() + d.first_dof());
  composed_ = added_up_ = true;
  factored_ = false;
}

void EffectiveInertia::build(const System& system, const State& state, const Step& step, double h) {
  add_up(system, state, step, h);
  if (factored_) return;
  factor_.factor(system.model, inertia_, scale_, total_, system.world.active.data());
  factored_ = true;
}

void EffectiveInertia::compose(const System& system, State& state) {
  if (composed_) return;
  const char* active = system.world.active.data();
  state.pose.kin.update_dofs(system.model, state.qpos.data(), active);
  inertia_.compose(system.model, state.pose.kin, active);
  drop_products();
}

void EffectiveInertia::drop_products() {
  for (Product& p : products_) p.root = 0;
}

void EffectiveInertia::multiply(const System& system, const Drive& d, const double* x,
                                double* out) const {
  const Model& m = system.model;
  const int root = m.root[d.body(0)], first = d.first_dof(), count = d.dof_count();
  for (const Product& p : products_) {
    if (p.root != root) continue;
    double sign = 0;
    if (std::equal(p.x.begin(), p.x.end(), x + first)) sign = 1;
    const auto opposite = [](double a, double b) { return a == -b; };
    if (sign == 0 && std::equal(p.x.begin(), p.x.end(), x + first, opposite)) sign = -1;
    if (sign == 0) continue;
    for (int i = 0; i < count; i++) out[first + i] = sign * p.Mx[i];
    return;
  }
  for (const Model::Tree& tree : m.trees)
    if (tree.first == root) inertia_.multiply(m, tree, x, out);
  Product& p = products_[next_product_];
  next_product_ = (next_product_ + 1) % kProducts;
  p.root = root;
  p.x.assign(x + first, x + first + count);
  p.Mx.assign(out + first, out + first + count);
}

void EffectiveInertia::add_drives(const System& system, const JointResistance& r, double h) {
  std::fill(drive_.begin(), drive_.end(), 0.0);
  for (size_t p = 0; p < system.drives.size(); p++) {
    const Drive& d = system.drives[p];
    if (!system.active(d)) continue;
    d.added_inertia(system.drive_settings, h, inertia_, drive_);
    const double s = d.scale(system.drive_settings, h);
    std::fill_n(scale_.begin() + d.first_dof(), d.dof_count(), s);
    if (r.rounds[p] == 0) continue;
    // Its joints exceed their strength: less of M^ - M.
    for (int i = d.first_dof(); i < d.first_dof() + d.dof_count(); i++) {
      const double share = r.share[i] * r.share[i];
      scale_[i] = 1 + (s - 1) * share;
      drive_[i] *= s * share / scale_[i];
    }
  }
}

void EffectiveInertia::hold_untouched(const System& system, const JointResistance& r) {
  if (system.drive_settings.time_constant == 0) return;
  for (size_t p = 0; p < system.drives.size(); p++) {
    const Drive& d = system.drives[p];
    if (!system.active(d) || !r.holds[p]) continue;
    for (int i = d.first_dof() + 6; i < d.first_dof() + d.dof_count(); i++)
      if (!r.touched[system.model.dof_body[i]]) total_[i] *= tune::kUntouchedResistance;
  }
}

void EffectiveInertia::stiffen_exits(const System& system, const State& state) {
  for (const Drive& d : system.drives) {
    if (!d.gentle() || !system.active(d)) continue;
    for (int i = d.first_dof() + 6; i < d.first_dof() + d.dof_count(); i++)
      total_[i] += (state.exit_path[system.model.dof_body[i]] ? tune::kExitPathInertia
                                                              : tune::kExitOtherInertia) *
                   inertia_.diagonal(i);
  }
}

// M^ + h D: `scale_` multiplies what stands in `total_`.
void EffectiveInertia::damp_joints(const System& system, double h) {
  for (const Drive& d : system.drives)
    for (int i = d.first_dof() + 6; i < d.first_dof() + d.dof_count(); i++)
      total_[i] += h * system.drive_settings.joint_damping / scale_[i];
}

}  // namespace hp
