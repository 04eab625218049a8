// What the paper leaves out, or argues against, on top of the same substep: to compare with
// (docs/physics.md, "Baselines"). Free motion is not exact with any of them: all of it is stepped through.
//
// Internal forces and damping are at work in M^ (v - v*) = J^T p like this, v0 what v* would be without:
//
//   (M^ + h D) (v* - v0) = -h c(q, v) - h D v0,     M^ + h D in place of M^
#include "stepping/stepper.h"

namespace hp {

namespace {

// Internal forces grow with the square of velocities and are those of the substep's start: limp limbs would
// run away with what that gains. They turn no joint faster than this, or than it was [rad/s]; Bullet has the
// same limit.
constexpr double kFastest = 100;

}  // namespace

// PD torques  tau = kp log(q^-1 q_target) - kd v,  kp = I w^2,  kd = 2 z I w,  with both at the end of the
// substep ("stable PD"; Tan, Liu & Turk 2011):
//
//   (M + h kd + h^2 kp) (v* - v) = h kp (eps - h v) - h kd v
//
// That is PJSC towards the target, of this firmness and with this share of eps.
double DriveSettings::torque_firmness(double h) const {
  const double wh = torque_frequency * h;
  return wh * (wh + 2 * torque_damping);
}

bool Drive::torque_deviation(const DriveSettings& s, double h, const double* qpos, const double* qvel,
                             double* deviation) const {
  const double wh = s.torque_frequency * h, share = wh / (wh + 2 * s.torque_damping);
  for (size_t i = 1; i < balls_.size(); i++) {
    const Ball& b = balls_[i];
    const Vec3 eps = log_quat(conjugate(load4(qpos + qpos0_ + b.qpos)) * load4(&target_[b.qpos]));
    store3(deviation + dof0_ + b.dof, share * eps - h * load3(qvel + dof0_ + b.dof));
  }
  return true;
}

// h D joins M^, which is `scale_` times what stands in extra_.
void Stepper::damp_joints(double h) {
  for (const Drive& d : drives_)
    for (int i = d.first_dof() + 6; i < d.first_dof() + d.dof_count(); i++)
      extra_[i] += h * drive_settings.joint_damping / scale_[i];
}

// The impulses -h c - h D v0 of the people's own forces, into torque_.
void Stepper::own_forces(double h) {
  own_impulse_.assign(model.nv, 0);
  std::vector<int> bodies;
  for (int b = 1; b < model.nbody; b++)
    if (is_person(b) && world.active[b]) bodies.push_back(b);
  if (drive_settings.internal_forces)
    bias_forces(model, start_.kin, qvel_.data(), {}, bodies, own_impulse_.data());
  for (double& c : own_impulse_) c *= -h;
  for (const Drive& d : drives_) {
    if (!world.active[d.body(0)]) continue;
    const int first = d.first_dof(), joints = first + 6, end = first + d.dof_count();
    for (int i = first; i < joints; i++) torque_[i] += own_impulse_[i];
    for (int i = joints; i < end; i++)
      torque_[i] += own_impulse_[i] - h * drive_settings.joint_damping * v_free_[i];
  }
}

// Cuts the change of velocity in torque_, which is v* - v0 by now.
void Stepper::limit_own() {
  for (const Drive& d : drives_)
    for (int i = 0; i < d.ball_count() && world.active[d.body(0)]; i++) {
      const int at = d.ball_dof(i);
      const Vec3 before = load3(&v_free_[at]), after = before + load3(&torque_[at]);
      const double most = std::max(kFastest, norm(before)), speed = norm(after);
      if (speed > most) store3(&torque_[at], (most / speed) * after - before);
    }
}

// What these forces did in a substep that ended with `v` the drive did not: off exerted_.
void Stepper::discount_own(const Drive& d, const double* v, double h) {
  const int first = d.first_dof();
  for (int i = first; i < first + d.dof_count(); i++)
    exerted_[i] -= own_impulse_[i] - (i < first + 6 ? 0 : h * drive_settings.joint_damping * v[i]);
}

}  // namespace hp
