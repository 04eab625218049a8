// Baseline: PD torques in place of the joints' velocities (docs/physics.md, "Forces that
// half-physics leaves out, and torques"):
//
//   tau = kp log(q^-1 q_target) - kd v,  kp = I w^2,  kd = 2 z I w,
//
// with both at the end of the substep ("stable PD"; Tan, Liu & Turk 2011):
//
//   (M + h kd + h^2 kp) (v* - v) = h kp (eps - h v) - h kd v
//
// That is PJSC towards the target, of the firmness below and with a share of eps.
#include "stepping/drive.h"

namespace hp {

double DriveSettings::torque_firmness(double h) const {
  const double wh = torque_frequency * h;
  return wh * (wh + 2 * torque_damping);
}

bool Drive::torque_deviation(const DriveSettings& s, double h, const double* qpos,
                             const double* qvel, double* deviation) const {
  const double wh = s.torque_frequency * h, share = wh / (wh + 2 * s.torque_damping);
  for (size_t i = 1; i < (size_t)ball_count(); i++) {
    const Ball& b = balls()[i];
    const Vec3 eps = log_quat(conjugate(load4(qpos + first_qpos() + b.qpos)) * motion.after(b));
    store3(deviation + first_dof() + b.dof, share * eps - h * load3(qvel + first_dof() + b.dof));
  }
  return true;
}

}  // namespace hp
