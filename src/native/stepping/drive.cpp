#include "stepping/drive.h"

#include <stdexcept>

#include "tuning.h"

namespace hp {

namespace tune = tuning::stepping;

namespace {

Vec3 difference(const double* from, const double* to) {
  return log_quat(conjugate(load4(from)) * load4(to));
}

Vec3 capped(Vec3 v, double limit) {
  double n = norm(v);
  return n > limit ? (limit / n) * v : v;
}

}  // namespace

Drive::Drive(const Model& m, int root_body) {
  auto need = [](bool ok) {
    if (!ok) throw std::invalid_argument("a person needs a free root and ball joints below it");
  };
  need(m.jnt_count[root_body] == 1 && m.jnt_type[m.jnt_first[root_body]] == Joint::Free);
  int j = m.jnt_first[root_body];
  qpos0_ = m.jnt_qpos[j];
  dof0_ = m.jnt_dof[j];
  nq_ = 7, nv_ = 6;
  balls_.push_back({3, 3, root_body});
  for (int b = root_body + 1; b < m.nbody && m.root[b] == root_body; b++)
    for (int i = m.jnt_first[b]; i < m.jnt_first[b] + m.jnt_count[b]; i++) {
      need(m.jnt_type[i] == Joint::Ball);
      balls_.push_back({m.jnt_qpos[i] - qpos0_, m.jnt_dof[i] - dof0_, b});
      nq_ += 4, nv_ += 3;
    }
  target_.resize(nq_);
  v_ref_.assign(nv_, 0);
  deviation_.assign(nv_, 0);
  v_drive_.assign(nv_, 0);
  impulse_.assign(nv_, 0);
  gain_.assign(nv_, 0);
  stiffness_.assign(balls_.size(), 1);
  lately_.assign(balls_.size(), 0);
}

void Drive::reset(const double* target, double* qvel) {
  target_.assign(target, target + nq_);
  previous_ = q_start_ = target_;
  for (auto* v : {&v_ref_, &deviation_, &v_drive_}) v->assign(nv_, 0);
  exerted_ = false;
  for (int i = 0; i < nv_; i++) qvel[dof0_ + i] = 0;
  std::fill(lately_.begin(), lately_.end(), 0.0);
  exact_ = fresh_ = true;
  gentle_left_ = 0;
  velocity_known_ = older_asked_ = true;
}

void Drive::go_gently(double speed, const std::vector<double>& reach) {
  if (gentle_left_ == 0) gentle_left_ = tune::kReturnTime;
  gentle_rate_.clear();
  for (const Ball& b : balls_) gentle_rate_.push_back(speed / std::max(reach[b.body], tune::kLeastJointReach));
}

void Drive::stay_gentle(bool comes_out, double dt, const double* qpos) {
  if (comes_out) {
    gentle_left_ = tune::kReturnTime;
    return;
  }
  gentle_left_ = std::max(0.0, gentle_left_ - dt);
  for (const Ball& b : balls_)
    if (norm(difference(&target_[b.qpos], qpos + qpos0_ + b.qpos)) > tune::kReturnAngle) return;
  gentle_left_ = 0;
}

void Drive::reference(double* v) const { std::copy(v_ref_.begin(), v_ref_.end(), v + dof0_); }

void Drive::reference_change(double* a) const { std::copy(gain_.begin(), gain_.end(), a + dof0_); }

void Drive::aim(const DriveSettings& s, const double* target, double dt, const double* qpos) {
  exerted_ = false;
  first_ = fresh_, fresh_ = false;
  older_asked_ = velocity_known_;
  older_dt_ = dt_, older_root_ = root_velocity_;
  velocity_known_ = true;
  dt_ = dt;
  older_.swap(previous_);
  previous_.swap(target_);
  target_.assign(target, target + nq_);
  root_velocity_ = (1 / dt) * (load3(target) - load3(previous_.data()));
  if (s.recover_root) {
    // Measured against the reference as it was when this pose was reached.
    Vec3 u = ((1 - std::exp(-dt / tune::kRootRecoveryTime)) / dt) *
             (load3(previous_.data()) - load3(qpos + qpos0_));
    root_velocity_ += capped(u, s.root_speed);
  }
}

bool Drive::settled(const DriveSettings& s, const double* qpos) const {
  if (s.own_forces() || s.torque()) return false;
  if (exact_) return true;
  if (s.time_constant > 0)
    for (double e : deviation_)
      if (std::fabs(e) > tune::kSettledSpeed) return false;
  for (const Ball& b : balls_) {
    Quat turn = conjugate(load4(&previous_[b.qpos])) * load4(qpos + qpos0_ + b.qpos);
    if (norm2(Vec3{turn.x, turn.y, turn.z}) > tune::kSettledAngle * tune::kSettledAngle) return false;
  }
  return true;
}

void Drive::follow(double share, double* qpos) const {
  double* q = qpos + qpos0_;
  store3(q, load3(q) + (share * dt_) * root_velocity_);
  for (const Ball& b : balls_) {
    Quat to = load4(&target_[b.qpos]), now = load4(q + b.qpos);
    // Of the two that are the same rotation, the one that goes on from where it is.
    if (to.w * now.w + to.x * now.x + to.y * now.y + to.z * now.z < 0)
      to = {-to.w, -to.x, -to.y, -to.z};
    if (share < 1) {
      Quat from = load4(&previous_[b.qpos]);
      to = normalized(from * exp_quat(share * log_quat(conjugate(from) * to)));
    }
    store4(q + b.qpos, to);
  }
}

void Drive::followed(bool exerts) {
  exact_ = true;
  velocity_known_ = false;
  exerted_ = exerted_ && exerts;
  for (auto* v : {&deviation_, &lately_}) std::fill(v->begin(), v->end(), 0.0);
}

void Drive::velocity(const std::vector<double>& from, const std::vector<double>& to, double dt,
                     Vec3 root, double* qvel) const {
  double* v = qvel + dof0_;
  store3(v, root);
  for (const Ball& b : balls_)
    store3(v + b.dof, (1 / dt) * difference(&from[b.qpos], &to[b.qpos]));
}

void Drive::velocity(double* qvel) const {
  if (!velocity_known_)
    velocity(previous_, target_, dt_, root_velocity_, qvel);
  else if (!older_asked_)
    velocity(older_, previous_, older_dt_, older_root_, qvel);
}

void Drive::speeds(std::vector<double>& angular, Vec3& root) const {
  root = root_velocity_;
  angular.resize(balls_.size());
  for (size_t i = 0; i < balls_.size(); i++) {
    int q = balls_[i].qpos;
    Quat turn = conjugate(load4(&previous_[q])) * load4(&target_[q]);
    double s = std::min(1.0, norm(Vec3{turn.x, turn.y, turn.z}));
    // 2 asin(s) <= 2 s + (pi - 2) s^3 on [0, 1].
    angular[i] = (2 * s + (M_PI - 2) * s * s * s) / dt_;
  }
}

void Drive::begin_frame(const DriveSettings& s, const double* qpos, double* qvel) {
  const double* q = qpos + qpos0_;
  velocity(qvel);
  older_asked_ = true;
  exact_ = false;
  const double rate = 1 / dt_;
  for (int i = 0; i < nv_; i++) gain_[i] = qvel[dof0_ + i] - deviation_[i];  // the last frame's
  store3(v_ref_.data(), root_velocity_);
  for (const Ball& b : balls_)
    store3(&v_ref_[b.dof], rate * difference(&previous_[b.qpos], &target_[b.qpos]));
  for (int i = 0; i < nv_; i++) gain_[i] = first_ ? 0 : rate * (v_ref_[i] - gain_[i]);
  if (s.time_constant > 0) return;
  q_start_.assign(q, q + nq_);
  store3(v_drive_.data(), root_velocity_);
  for (size_t i = 0; i < balls_.size(); i++) {
    const Ball& b = balls_[i];
    Vec3 w = rate * difference(q + b.qpos, &target_[b.qpos]);
    if (gentle()) {
      const Vec3 asked = load3(&v_ref_[b.dof]);
      w = asked + capped(w - asked, gentle_rate_[i]);
    }
    store3(&v_drive_[b.dof], w);
  }
  const int set = s.torque() ? 6 : nv_;  // torques leave the joints as they are
  for (int i = 0; i < set; i++) qvel[dof0_ + i] = v_drive_[i];
  if (s.torque()) v_ref_.assign(nv_, 0);  // all of a velocity is deviation
}

void Drive::added_inertia(const DriveSettings& s, double h, const Model& m, const Inertia& inertia,
                          std::vector<double>& extra) const {
  for (size_t i = 1; i < balls_.size(); i++) {
    int d = dof0_ + balls_[i].dof;
    double mean = 0;
    for (int c = 0; c < 3; c++) mean += inertia.diagonal(m, d + c) / 3;
    for (int c = 0; c < 3; c++) extra[d + c] = (s.torque() ? s.torque_firmness(h) : stiffness_[i]) * mean;
  }
}

double Drive::scale(const DriveSettings& s, double h) const {
  if (s.time_constant == 0) return 1;
  double r = h / s.time_constant;
  return 1 + 2 * r + r * r;
}

bool Drive::free_velocity(const DriveSettings& s, int k, double h, const double* qpos,
                          const double* qvel, double* v_free, double* deviation) const {
  const double* q = qpos + qpos0_;
  double* v = v_free + dof0_;
  if (s.time_constant > 0) {
    double tau = s.time_constant, sc = scale(s, h), limit = 2 * s.recovery_rate * tau;
    for (int i = 0; i < 3; i++) v[i] = v_ref_[i] + deviation_[i] / sc;
    for (size_t i = 0; i < balls_.size(); i++) {
      const Ball& b = balls_[i];
      Quat ref = load4(&previous_[b.qpos]) * exp_quat((k * h) * load3(&v_ref_[b.dof]));
      const double most = gentle() ? std::min(limit, 2 * gentle_rate_[i] * tau) : limit;
      Vec3 xi = capped(log_quat(conjugate(ref) * load4(q + b.qpos)), most);
      Vec3 e = load3(&deviation_[b.dof]) - (h / (tau * tau)) * xi;
      store3(v + b.dof, load3(&v_ref_[b.dof]) + (1 / sc) * e);
    }
    return false;
  }
  for (int i = 0; i < nv_; i++) v[i] = qvel[dof0_ + i];
  if (s.torque()) return torque_deviation(s, h, qpos, qvel, deviation);
  bool any = false;
  double* out = deviation + dof0_;
  for (size_t i = 1; i < balls_.size(); i++) {
    if (stiffness_[i] == 0) continue;
    const Ball& b = balls_[i];
    Quat expected = load4(&q_start_[b.qpos]) * exp_quat(((k + 1) * h) * load3(&v_drive_[b.dof]));
    Vec3 way = h * load3(v + b.dof), turn = log_quat(conjugate(load4(q + b.qpos)) * expected);
    // About a half turn rounding decides which way round the log goes; it is the way it turns.
    double angle = norm(turn);
    if (dot(turn, way) < 0 && angle > 0.5 * M_PI) turn = (1 - 2 * M_PI / angle) * turn;
    Vec3 eps = turn - way;
    // Rounding alone (free motion) must not cost a factor.
    if (norm2(eps) < tune::kLeastDeviation2) continue;
    any = true;
    store3(out + b.dof, eps);
  }
  return any;
}

void Drive::end_substep(const double* qvel, double h, const std::vector<char>& pushed) {
  for (size_t i = 0; i < balls_.size(); i++)
    lately_[i] = pushed[balls_[i].body] ? tune::kTouchedTime : std::max(0.0, lately_[i] - h);
  for (int i = 0; i < nv_; i++) deviation_[i] = qvel[dof0_ + i] - v_ref_[i];
}

void Drive::save(std::vector<double>& out) const {
  for (const auto* v : {&target_, &v_ref_, &deviation_, &stiffness_, &lately_})
    out.insert(out.end(), v->begin(), v->end());
  out.insert(out.end(), {(exact_ ? 1.0 : 0.0) + (fresh_ ? 2.0 : 0.0), gentle_left_});
}

const double* Drive::load(const double* in) {
  for (auto* v : {&target_, &v_ref_, &deviation_, &stiffness_, &lately_}) {
    std::copy(in, in + v->size(), v->begin());
    in += v->size();
  }
  previous_ = q_start_ = target_;
  const int flags = (int)*in++;
  exact_ = (flags & 1) != 0, fresh_ = (flags & 2) != 0;
  gentle_left_ = *in++;
  velocity_known_ = older_asked_ = true;
  return in;
}

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

}  // namespace hp
