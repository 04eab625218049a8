#include "stepping/reference_motion.h"

#include "stepping/drive.h"
#include "tuning.h"

namespace hp {

namespace tune = tuning::stepping;

void ReferenceMotion::reset(const double* target) {
  target_.assign(target, target + dofs_.qpos_count());
  previous_ = target_;
  fresh_ = true;
  beside_ = {};
  velocity_known_ = older_asked_ = true;
}

void ReferenceMotion::aim(const DriveSettings& s, const double* target, double dt,
                          const double* qpos, bool weight) {
  first_ = fresh_, fresh_ = false;
  older_asked_ = velocity_known_;
  older_dt_ = dt_, older_root_ = root_velocity_;
  velocity_known_ = true;
  dt_ = dt;
  older_.swap(previous_);
  previous_.swap(target_);
  target_.assign(target, target + dofs_.qpos_count());
  beside_before_ = beside_;
  beside_ = beside(s, previous_, target, dt, qpos, weight);
  root_velocity_ = (1 / dt) * (load3(target) - load3(previous_.data())) + beside_;
}

// Measured against the reference as it was when this pose was reached.
Vec3 ReferenceMotion::beside(const DriveSettings& s, const std::vector<double>& reached,
                             const double* next, double dt, const double* qpos, bool weight) const {
  if (!s.recover_root && !weight) return {};
  const Vec3 off = load3(reached.data()) - load3(qpos + dofs_.first_qpos());
  Vec3 back;
  if (s.recover_root)
    back = eager *
           capped(((1 - elementary::exp(-dt / tune::kRootRecoveryTime)) / dt) * off, s.root_speed);
  if (weight) {
    const double fall = (1 - elementary::exp(-dt / tune::kFallTime)) / dt * off.z;
    back.z = std::clamp(fall, -tune::kFallSpeed, s.root_speed);
  }
  if (!goes_round) return back;
  const Vec3 own = (1 / dt) * (load3(next) - load3(reached.data()));
  return {goes.x - own.x, goes.y - own.y, back.z};
}

Vec3 ReferenceMotion::displaced(const DriveSettings& s, const double* next, double dt,
                                const double* qpos) const {
  const Vec3 back = beside(s, target_, next, dt, qpos, true);
  Vec3 off = load3(qpos + dofs_.first_qpos()) - load3(target_.data());
  off.x += dt * back.x, off.y += dt * back.y;
  return off;
}

void ReferenceMotion::follow(double share, double* qpos) const {
  double* q = qpos + dofs_.first_qpos();
  store3(q, load3(q) + (share * dt_) * root_velocity_);
  for (const PersonDofs::Ball& b : dofs_.balls()) {
    Quat to = after(b), now = load4(q + b.qpos);
    // Of the two that are the same rotation, the one that goes on from where it is.
    if (to.w * now.w + to.x * now.x + to.y * now.y + to.z * now.z < 0)
      to = {-to.w, -to.x, -to.y, -to.z};
    if (share < 1) {
      const Quat from = before(b);
      to = normalized(from * exp_quat(share * log_quat(conjugate(from) * to)));
    }
    store4(q + b.qpos, to);
  }
}

void ReferenceMotion::put(double share, double* qpos) const {
  double* q = qpos + dofs_.first_qpos();
  if (share >= 1) {
    std::copy(target_.begin(), target_.end(), q);
    return;
  }
  const Vec3 from = load3(previous_.data()), to = load3(target_.data());
  store3(q, from + share * (to - from));
  for (const PersonDofs::Ball& b : dofs_.balls()) {
    const Quat begin = before(b), end = after(b);
    store4(q + b.qpos, normalized(begin * exp_quat(share * log_quat(conjugate(begin) * end))));
  }
}

Quat ReferenceMotion::at(const PersonDofs::Ball& b, double share) const {
  const Quat from = before(b), to = after(b);
  return share < 1 ? normalized(from * exp_quat(share * log_quat(conjugate(from) * to))) : to;
}

void ReferenceMotion::difference(const std::vector<double>& from, const std::vector<double>& to,
                                 double dt, Vec3 root, double* v) const {
  store3(v, root);
  for (const PersonDofs::Ball& b : dofs_.balls())
    store3(v + b.dof, (1 / dt) * rotation_between(&from[b.qpos], &to[b.qpos]));
}

void ReferenceMotion::velocity(double* qvel) const {
  double* v = qvel + dofs_.first_dof();
  if (!velocity_known_)
    difference(previous_, target_, dt_, root_velocity_, v);
  else if (!older_asked_)
    difference(older_, previous_, older_dt_, older_root_, v);
}

void ReferenceMotion::reference(double* v) const {
  difference(previous_, target_, dt_, root_velocity_, v);
}

void ReferenceMotion::speeds(std::vector<double>& angular) const {
  const std::vector<PersonDofs::Ball>& balls = dofs_.balls();
  angular.resize(balls.size());
  for (size_t i = 0; i < balls.size(); i++) {
    const Quat turn = conjugate(before(balls[i])) * after(balls[i]);
    const double s = std::min(1.0, norm(Vec3{turn.x, turn.y, turn.z}));
    // 2 asin(s) <= 2 s + (pi - 2) s^3 on [0, 1].
    angular[i] = (2 * s + (M_PI - 2) * s * s * s) / dt_;
  }
}

void ReferenceMotion::restore(const double* target, bool fresh, Vec3 beside) {
  target_.assign(target, target + dofs_.qpos_count());
  previous_ = target_;
  fresh_ = fresh;
  beside_ = beside;
  velocity_known_ = older_asked_ = true;
}

}  // namespace hp
