#include "stepping/hosting.h"

#include <cmath>

#include "tuning.h"

namespace hp {

void Hosting::begin(System& system, Data& data, Aiming& aiming, const double* targets, double dt) {
  State& state = data.state;
  aiming.begin(system, data, targets, dt);
  settled_.clear();
  system.world.active.assign(system.model.nbody, 1);
  for (Drive& d : system.drives) {
    settled_.push_back(d.settled(system.drive_settings, state.qpos.data()));
    d.begin_frame(system.drive_settings, state.qpos.data(), state.qvel.data());
  }
  start_qpos_ = state.qpos;
}

// Differences up to kPlacedByHost are rounding between two engines' integration; a body that is
// farther from where it was left has been put there.
Hosting::Change Hosting::take_pose(const System& system, State& state, const double* qpos) const {
  const Model& model = system.model;
  Change change = Change::None;
  for (int j = 0; j < model.njnt; j++) {
    if (system.is_person(model.jnt_body[j])) continue;
    const int first = model.jnt_qpos[j], count = qpos_width(model.jnt_type[j]);
    for (int i = first; i < first + count; i++) {
      if (qpos[i] != state.qpos[i] && change == Change::None) change = Change::Rounding;
      if (std::fabs(qpos[i] - state.qpos[i]) > tuning::stepping::kPlacedByHost)
        change = Change::Placed;
      state.qpos[i] = qpos[i];
    }
  }
  return change;
}

void Hosting::substep(System& system, Data& data, Substep& substep, int k, double h,
                      const double* qpos, const double* qvel, const double* v_free,
                      const double* damping) {
  const Model& model = system.model;
  State& state = data.state;
  const Change change = take_pose(system, state, qpos);
  std::vector<double>& host_damping = data.step.resistance.damping;
  host_damping.assign(damping, damping + model.nv);
  for (int i = 0; i < model.nv; i++) {
    const bool person = system.is_person(model.dof_body[i]);
    if (person) host_damping[i] = 0;
    if (!person) state.qvel[i] = qvel[i];
  }
  if (change != Change::None) state.pose_known = false;
  state.update_pose(system);
  if (change == Change::Placed) system.world.broad_phase.forget();
  for (int b = 1; b < model.nbody; b++)
    if (!system.is_person(b)) data.result.disturbed[b] = 0;
  data.step.host_v_free = v_free;
  data.budget.begin_frame(1, (int)system.drives.size());
  data.budget.begin_substep(1);
  substep.run(k, h);
  data.step.host_v_free = nullptr;
}

void Hosting::end(System& system, Data& data) {
  State& state = data.state;
  Aiming::end(system, data.result);
  end_gentle_frame(system, state);
  for (size_t i = 0; i < system.drives.size(); i++) {
    Drive& d = system.drives[i];
    // As in Stepper::frame(): people whom nothing touched have arrived.
    if (!settled_[i] || data.result.disturbed[d.body(0)]) continue;
    std::copy_n(&start_qpos_[d.first_qpos()], d.qpos_count(), &state.qpos[d.first_qpos()]);
    d.motion.follow(1, state.qpos.data());
    d.followed();
    state.pose_known = false;
  }
}

}  // namespace hp
