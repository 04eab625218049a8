#include "stepping/baselines/internal_forces.h"

#include "stepping/data.h"
#include "tuning.h"

namespace hp {

void InternalForces::add_impulses(const System& system, const State& state, const Step& step,
                                  double h, std::vector<double>& impulse) {
  const Model& model = system.model;
  const DriveSettings& settings = system.drive_settings;
  impulse_.assign(model.nv, 0);
  std::vector<int> bodies;
  for (int b = 1; b < model.nbody; b++)
    if (system.is_person(b) && system.world.active[b]) bodies.push_back(b);
  if (settings.internal_forces)
    bias_forces(model, state.pose.kin, state.qvel.data(), {}, bodies, impulse_.data());
  for (double& c : impulse_) c *= -h;
  for (const Drive& d : system.drives) {
    if (!system.active(d)) continue;
    const int first = d.first_dof(), joints = first + 6, end = first + d.dof_count();
    for (int i = first; i < joints; i++) impulse[i] += impulse_[i];
    for (int i = joints; i < end; i++)
      impulse[i] += impulse_[i] - h * settings.joint_damping * step.v_free[i];
  }
}

void InternalForces::limit(const System& system, const Step& step,
                           std::vector<double>& change) const {
  for (const Drive& d : system.drives)
    for (int i = 0; i < d.ball_count() && system.active(d); i++) {
      const int at = d.ball_dof(i);
      const Vec3 before = load3(&step.v_free[at]), after = before + load3(&change[at]);
      const double most = std::max(tuning::stepping::kFastestInternalSpin, norm(before));
      const double speed = norm(after);
      if (speed > most) store3(&change[at], (most / speed) * after - before);
    }
}

void InternalForces::discount(const System& system, const Drive& d, const double* v, double h,
                              double* impulse) const {
  const int first = d.first_dof();
  for (int i = first; i < first + d.dof_count(); i++)
    impulse[i] -=
        impulse_[i] - (i < first + 6 ? 0 : h * system.drive_settings.joint_damping * v[i]);
}

}  // namespace hp
