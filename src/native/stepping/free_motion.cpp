// What a substep would do without contact: the drive's pull on people, gravity and spin of objects.
#include "stepping/stepper.h"

namespace hp {

namespace {

// Who comes out of something, or just has, resists as if its joints had so many times more inertia: on
// the ways from the root to what comes out, so that it goes as a whole, and elsewhere, so that what
// pushes a foot does not swing an arm.
constexpr double kFirm = 3, kLock = 300;

}  // namespace

void Stepper::stiffen() {
  for (const Drive& d : drives_) {
    if (!d.gentle() || !world.active[d.body(0)]) continue;
    for (int i = d.first_dof() + 6; i < d.first_dof() + d.dof_count(); i++)
      extra_[i] += (way_out_[model.dof_body[i]] ? kFirm : kLock) * inertia_.diagonal(model, i);
  }
}

void Stepper::build_inertia(double h) {
  if (inertia_ready_ && factored_) return;
  if (!inertia_ready_) inertia_.compose(model, start_.kin, world.active.data());
  std::fill(extra_.begin(), extra_.end(), 0.0);
  for (const Drive& d : drives_) {
    if (!world.active[d.body(0)]) continue;
    d.added_inertia(drive_settings, h, model, inertia_, extra_);
    double s = d.scale(drive_settings, h);
    std::fill_n(scale_.begin() + d.first_dof(), d.dof_count(), s);
    if (overcome_[&d - drives_.data()] == 0) continue;
    // Less of what it adds, M^ - M: its joints give in (strength.cpp).
    for (int i = d.first_dof(); i < d.first_dof() + d.dof_count(); i++) {
      const double share = share_[i] * share_[i];
      scale_[i] = 1 + (s - 1) * share;
      extra_[i] *= s * share / scale_[i];
    }
  }
  articulations.added_inertia(model, world.active, h, extra_);
  const std::vector<double> drive = extra_;
  for (size_t i = 0; i < hosted_damping_.size(); i++) extra_[i] += h * hosted_damping_[i];
  hold_untouched();
  stiffen();
  if (drive_settings.joint_damping > 0) damp_joints(h);
  inertia_.factor(model, scale_, extra_, world.active.data());
  for (const Drive& d : drives_)  // who stands keeps what is known of it
    if (world.active[d.body(0)])
      std::copy_n(extra_.begin() + d.first_dof(), d.dof_count(), resist_.begin() + d.first_dof());
  extra_ = drive;
  inertia_ready_ = factored_ = true;
}

// Gravity, and the free rotation by the implicit midpoint rule. The pose moves with the midpoint
// velocity; `spin_` keeps what is then missing to the velocity at the end of the substep.
void Stepper::object_velocity(double h, const std::vector<char>* only) {
  for (int b : objects_) {
    if (!world.active[b] || model.held[b] || world.asleep[b] || (only && !(*only)[b])) continue;
    int d = model.dof_first[b];
    Vec3 v = load3(&qvel_[d]) + h * gravity, w0 = load3(&qvel_[d + 3]);
    Mat3 R = to_matrix(model.iquat[b]), I;
    for (int i = 0; i < 3; i++)
      for (int j = 0; j < 3; j++) {
        I.m[3 * i + j] = 0;
        for (int a = 0; a < 3; a++)
          I.m[3 * i + j] += R.m[3 * i + a] * model.inertia[b][a] * R.m[3 * j + a];
      }
    // Newton on  2 I (w - w0) + h w x I w = 0  for the midpoint velocity w.
    Vec3 w = w0, L0 = I * w0;
    for (int it = 0; it < 20; it++) {
      Vec3 Lw = I * w, f = 2.0 * (Lw - L0) + h * cross(w, Lw);
      if (norm2(f) <= 1e-32 * (norm2(L0) + 1e-300)) break;
      Mat3 D;
      for (int j = 0; j < 3; j++) {
        Vec3 e;
        e[j] = 1;
        Vec3 Ie = I.col(j), c = 2.0 * Ie + h * (cross(e, Lw) + cross(w, Ie));
        for (int i = 0; i < 3; i++) D.m[3 * i + j] = c[i];
      }
      w -= solve3(D, f);
    }
    store3(&v_free_[d], v);
    store3(&v_free_[d + 3], w);
    store3(&spin_[d + 3], w - w0);
  }
}

void Stepper::free_velocity(int k, double h) {
  v_free_ = qvel_;
  std::fill(torque_.begin(), torque_.end(), 0.0);
  bool any = false;
  for (const Drive& d : drives_)
    if (world.active[d.body(0)])
      any |= d.free_velocity(drive_settings, k, h, qpos_.data(), qvel_.data(), v_free_.data(),
                             torque_.data());
  const bool trees = articulations.any(model, world.active);
  const bool own = drive_settings.own_forces();
  if (any || trees || own) {
    build_inertia(h);
    for (int i = 0; i < model.nv; i++) torque_[i] *= extra_[i] / h;
    if (trees)
      articulations.impulse(model, start_.kin, world.active, gravity, qpos_.data(), qvel_.data(), h,
                            torque_.data());
    if (own) own_forces(h);
    inertia_.solve(model, torque_.data());
    if (drive_settings.internal_forces) limit_own();
    for (int i = 0; i < model.nv; i++) v_free_[i] += torque_[i];
    for (int i : articulations.dofs()) pull_[i] = torque_[i];
  }
  if (hosted_free_) {
    for (int i = 0; i < model.nv; i++)
      if (!is_person(model.dof_body[i])) v_free_[i] = hosted_free_[i];
    return;
  }
  find_load(h);
  limit_strength(h);
  bear_load(h);
  object_velocity(h);
  given_velocity(h);
}

}  // namespace hp
