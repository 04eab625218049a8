#include "drive.h"

#include <stdexcept>

namespace hp {

namespace {

constexpr double kRootTime = 0.3;  // time constant of root recovery [s]

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
  balls_.push_back({3, 3});
  for (int b = root_body + 1; b < m.nbody && m.root[b] == root_body; b++)
    for (int i = m.jnt_first[b]; i < m.jnt_first[b] + m.jnt_count[b]; i++) {
      need(m.jnt_type[i] == Joint::Ball);
      balls_.push_back({m.jnt_qpos[i] - qpos0_, m.jnt_dof[i] - dof0_});
      nq_ += 4, nv_ += 3;
    }
  target_.resize(nq_);
  v_ref_.assign(nv_, 0);
  deviation_.assign(nv_, 0);
  v_drive_.assign(nv_, 0);
}

void Drive::reset(const double* target, double* qvel) {
  target_.assign(target, target + nq_);
  previous_ = q_start_ = target_;
  for (auto* v : {&v_ref_, &deviation_, &v_drive_}) v->assign(nv_, 0);
  for (int i = 0; i < nv_; i++) qvel[dof0_ + i] = 0;
}

void Drive::begin_frame(const Model&, const DriveSettings& s, const double* target, double dt,
                        const double* qpos, double* qvel) {
  const double* q = qpos + qpos0_;
  previous_ = target_;
  target_.assign(target, target + nq_);
  Vec3 root = (1 / dt) * (load3(target) - load3(previous_.data()));
  if (s.recover_root) {
    // Measured against the reference as it was when this pose was reached.
    Vec3 u = ((1 - std::exp(-dt / kRootTime)) / dt) * (load3(previous_.data()) - load3(q));
    root += capped(u, s.root_speed);
  }
  store3(v_ref_.data(), root);
  for (const Ball& b : balls_)
    store3(&v_ref_[b.dof], (1 / dt) * difference(&previous_[b.qpos], target + b.qpos));
  if (s.time_constant == 0) {
    q_start_.assign(q, q + nq_);
    store3(v_drive_.data(), root);
    for (const Ball& b : balls_)
      store3(&v_drive_[b.dof], (1 / dt) * difference(q + b.qpos, target + b.qpos));
    for (int i = 0; i < nv_; i++) qvel[dof0_ + i] = v_drive_[i];
  }
}

void Drive::added_inertia(const Model& m, const Inertia& inertia, const DriveSettings& s,
                          std::vector<double>& extra) const {
  for (size_t i = 1; i < balls_.size(); i++) {
    int d = dof0_ + balls_[i].dof;
    double mean = 0;
    for (int c = 0; c < 3; c++) mean += inertia.diagonal(m, d + c) / 3;
    for (int c = 0; c < 3; c++) extra[d + c] = s.stiffness * mean;
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
    for (const Ball& b : balls_) {
      Quat ref = load4(&previous_[b.qpos]) * exp_quat((k * h) * load3(&v_ref_[b.dof]));
      Vec3 xi = capped(log_quat(conjugate(ref) * load4(q + b.qpos)), limit);
      Vec3 e = load3(&deviation_[b.dof]) - (h / (tau * tau)) * xi;
      store3(v + b.dof, load3(&v_ref_[b.dof]) + (1 / sc) * e);
    }
    return false;
  }
  for (int i = 0; i < nv_; i++) v[i] = qvel[dof0_ + i];
  if (s.stiffness == 0) return false;
  bool any = false;
  double* out = deviation + dof0_;
  for (size_t i = 1; i < balls_.size(); i++) {
    const Ball& b = balls_[i];
    Quat expected = load4(&q_start_[b.qpos]) * exp_quat(((k + 1) * h) * load3(&v_drive_[b.dof]));
    Vec3 way = h * load3(v + b.dof), turn = log_quat(conjugate(load4(q + b.qpos)) * expected);
    // About a half turn rounding decides which way round the log goes; it is the way it turns.
    double angle = norm(turn);
    if (dot(turn, way) < 0 && angle > 0.5 * M_PI) turn = (1 - 2 * M_PI / angle) * turn;
    Vec3 eps = turn - way;
    // Rounding alone (free motion) must not cost a factor.
    if (norm2(eps) < 1e-26) continue;
    any = true;
    store3(out + b.dof, eps);
  }
  return any;
}

void Drive::end_substep(const double* qvel) {
  for (int i = 0; i < nv_; i++) deviation_[i] = qvel[dof0_ + i] - v_ref_[i];
}

void Drive::save(std::vector<double>& out) const {
  for (const auto* v : {&target_, &v_ref_, &deviation_}) out.insert(out.end(), v->begin(), v->end());
}

const double* Drive::load(const double* in) {
  for (auto* v : {&target_, &v_ref_, &deviation_}) {
    std::copy(in, in + v->size(), v->begin());
    in += v->size();
  }
  previous_ = q_start_ = target_;
  return in;
}

}  // namespace hp
