// A frame in somebody else's world: their engine moves all that is no person, we push.
#include <cmath>

#include "stepping/stepper.h"

namespace hp {

namespace {

// Rounding between two engines' integration; whatever is farther from where it was left has been
// put there [m, rad].
constexpr double kPut = 1e-12;

}  // namespace

void Stepper::begin_hosted(const double* targets, double dt) {
  touches_.clear();
  diagnostics_ = {};
  disturbed_.assign(model.nbody, 0);
  settled_.clear();
  world.active.assign(model.nbody, 1);
  for (Drive& d : drives_) {
    d.aim(drive_settings, targets, dt, qpos_.data());
    settled_.push_back(d.settled(drive_settings, qpos_.data()));
    targets += d.qpos_count();
    d.begin_frame(drive_settings, qpos_.data(), qvel_.data());
  }
  q_start_ = qpos_;
}

void Stepper::substep_hosted(int k, double h, const double* qpos, const double* qvel,
                             const double* free, const double* damping) {
  bool same = true, put = false;
  for (int j = 0; j < model.njnt; j++) {
    if (is_person(model.jnt_body[j])) continue;
    const int first = model.jnt_qpos[j], count = qpos_width(model.jnt_type[j]);
    for (int i = first; i < first + count; i++) {
      same &= qpos[i] == qpos_[i];
      put |= std::fabs(qpos[i] - qpos_[i]) > kPut;
      qpos_[i] = qpos[i];
    }
  }
  hosted_damping_.assign(damping, damping + model.nv);
  for (int i = 0; i < model.nv; i++) {
    const bool person = is_person(model.dof_body[i]);
    if (person) hosted_damping_[i] = 0;
    if (!person) qvel_[i] = qvel[i];
  }
  if (!same) pose_known_ = false;
  start_pose();
  if (put) world.forget();
  for (int b = 1; b < model.nbody; b++)
    if (!is_person(b)) disturbed_[b] = 0;
  hosted_free_ = free;
  substep(k, h);
  hosted_free_ = nullptr;
}

void Stepper::end_hosted() {
  for (size_t i = 0; i < drives_.size(); i++) {
    Drive& d = drives_[i];
    if (d.gentle()) d.stay_gentle(comes_out(d), d.frame_length(), qpos_.data());
    // As in frame(): whom nothing touched has arrived.
    if (!settled_[i] || disturbed_[d.body(0)]) continue;
    std::copy_n(&q_start_[d.first_qpos()], d.qpos_count(), &qpos_[d.first_qpos()]);
    d.follow(1, qpos_.data());
    d.followed();
    pose_known_ = false;
  }
}

}  // namespace hp
