#include "dynamics/articulation.h"

#include "tuning.h"

#include <cmath>
#include <limits>
#include <stdexcept>

#include "dynamics/inertia.h"

namespace hp {

namespace tune = tuning::dynamics;

namespace {

// Of a force (moment, force) that is carried along by a motion.
Twist cross_force(Twist v, Twist f) { return {cross(v.w, f.w) + cross(v.v, f.v), cross(v.w, f.v)}; }

}  // namespace

void bias_forces(const Model& m, const Kinematics& k, const double* qvel, Vec3 gravity,
                 const std::vector<int>& bodies, double* out, const double* qacc,
                 const std::vector<char>* massive) {
  std::vector<Twist> velocity(m.nbody), acceleration(m.nbody), force(m.nbody);
  acceleration[0].v = -gravity;
  for (int b : bodies) {
    Twist v = velocity[m.parent[b]], a = acceleration[m.parent[b]];
    carry(m, k, qvel, b, v, a);
    const int dof = m.dof_first[b];
    for (int d = dof; qacc && d < dof + m.dof_count[b]; d++) a = a + scaled(qacc[d], k.cdof[d]);
    velocity[b] = v, acceleration[b] = a;
    if (massive && !(*massive)[b]) continue;
    const Inertia::Composite I = Inertia::of_body(m, k, b);
    force[b] = I * a + cross_force(v, I * v);
  }
  for (size_t i = bodies.size(); i-- > 0;) {
    const int b = bodies[i];
    for (int d = m.dof_first[b]; d < m.dof_first[b] + m.dof_count[b]; d++)
      out[d] = dot(k.cdof[d].w, force[b].w) + dot(k.cdof[d].v, force[b].v);
    force[m.parent[b]] = force[m.parent[b]] + force[b];
  }
}

void Articulations::finish(const Model& m, const std::vector<char>& others) {
  joints.damping.resize(m.nv, 0.0);
  joints.stiffness.resize(m.njnt, 0.0);
  if (joints.spring.empty()) joints.spring = m.qpos0;
  joints.limited.resize(m.njnt, 0);
  joints.lower.resize(m.njnt, 0.0);
  joints.upper.resize(m.njnt, 0.0);
  joints.effort.assign(m.njnt, std::numeric_limits<double>::infinity());
  joints.rate.assign(m.njnt, 0.0);
  driven_.assign(m.njnt, 0.0), effort_.assign(m.njnt, Effort::Within);
  joints.motors.clear(), balanced_.assign(m.nbody, 0);
  bodies_.clear(), dofs_.clear(), joints_.clear(), ends_.clear(), end_joint_.clear();
  std::vector<char> moves(m.nbody, 0);
  for (int b = 1; b < m.nbody; b++)
    if (!others[m.root[b]] && m.dof_count[b] > 0) moves[m.root[b]] = 1;
  for (int b = 1; b < m.nbody; b++) {
    if (!moves[m.root[b]]) continue;
    bodies_.push_back(b);
    for (int d = m.dof_first[b]; d < m.dof_first[b] + m.dof_count[b]; d++) dofs_.push_back(d);
    for (int j = m.jnt_first[b]; j < m.jnt_first[b] + m.jnt_count[b]; j++) {
      joints_.push_back(j);
      if (!joints.limited[j] || (m.jnt_type[j] != Joint::Hinge && m.jnt_type[j] != Joint::Slide))
        continue;
      for (double sign : {1.0, -1.0}) {
        Contact c;
        c.n = {1, 0, 0}, c.t = {0, 1, 0}, c.s = {0, 0, 1};
        c.a.bends = std::make_shared<const std::vector<Endpoint::Bend>>(
            1, Endpoint::Bend{m.jnt_dof[j], {sign, 0, 0}});
        ends_.push_back(c);
        end_joint_.push_back(j);
      }
    }
  }
}

void Articulations::set_motors(const Model& m, const std::vector<int>& motors,
                               const std::vector<double>& effort) {
  for (size_t i = 0; i < motors.size(); i++) {
    const int j = motors[i];
    if (!std::binary_search(joints_.begin(), joints_.end(), j) || qpos_width(m.jnt_type[j]) != 1)
      throw std::invalid_argument("set_motors: expected hinges and slides of articulated objects");
    if (!(effort[i] >= 0)) throw std::invalid_argument("set_motors: expected efforts of 0 or more");
  }
  joints.motors = motors;
  joints.rate.assign(m.njnt, 0.0);
  balanced_.assign(m.nbody, 0);
  for (size_t i = 0; i < motors.size(); i++) joints.effort[motors[i]] = effort[i];
  for (int j : motors)
    for (int b : bodies_)
      if (m.root[b] == m.root[m.jnt_body[j]]) balanced_[b] = 1;
}

void Articulations::set_rests(const Model& m, const double* rests, const double* rates) {
  for (size_t i = 0; i < joints.motors.size(); i++) {
    const int j = joints.motors[i];
    joints.spring[m.jnt_qpos[j]] = rests[i];
    joints.rate[j] = rates[i];
  }
}

// What the spring of a hinge or slide exerts on a joint that stands.
double Articulations::asked(const Model& m, int joint, const double* qpos) const {
  const int q = m.jnt_qpos[joint];
  return -joints.stiffness[joint] * (qpos[q] - joints.spring[q]) +
         joints.damping[m.jnt_dof[joint]] * joints.rate[joint];
}

void Articulations::find_efforts(const Model& m, const std::vector<char>& active,
                                 const Inertia& own, const double* qpos, const double* qvel,
                                 double h) {
  for (int j : joints.motors) {
    if (!active[m.jnt_body[j]]) continue;
    const int d = m.jnt_dof[j];
    const double K = joints.stiffness[j], D = joints.damping[d], inertia = own.diagonal(d);
    const double pull = asked(m, j, qpos), now = pull - D * qvel[d], most = joints.effort[j];
    const double then = (now - h * K * qvel[d]) * inertia / (inertia + h * D + h * h * K);
    effort_[j] = std::fabs(now) <= most    ? Effort::Within
                 : std::fabs(then) <= most ? Effort::AtFirst
                                           : Effort::AllAlong;
    driven_[j] = std::copysign(most, effort_[j] == Effort::AllAlong ? then : now);
  }
}

bool Articulations::any(const Model& m, const std::vector<char>& active) const {
  for (int d : dofs_)
    if (active[m.dof_body[d]]) return true;
  return false;
}

void Articulations::added_inertia(const Model& m, const std::vector<char>& active, double h,
                                  std::vector<double>& extra) const {
  for (int j : joints_) {
    if (!active[m.jnt_body[j]]) continue;
    const int count = m.jnt_type[j] == Joint::Free ? 6 : m.jnt_type[j] == Joint::Ball ? 3 : 1;
    const bool driven = effort_[j] == Effort::AllAlong;
    for (int d = m.jnt_dof[j]; d < m.jnt_dof[j] + count && !driven; d++)
      extra[d] = h * joints.damping[d] + (count < 6 ? h * h * joints.stiffness[j] : 0.0);
  }
}

void Articulations::impulse(const Model& m, const Kinematics& k, const std::vector<char>& active,
                            Vec3 gravity, const double* qpos, const double* qvel, double h,
                            double* out) {
  moving_.clear(), moving_balanced_.clear();
  for (int b : bodies_)
    if (active[b]) (balanced_[b] ? moving_balanced_ : moving_).push_back(b);
  bias_.resize(m.nv);
  if (!moving_.empty()) bias_forces(m, k, qvel, gravity, moving_, bias_.data());
  if (!moving_balanced_.empty()) bias_forces(m, k, qvel, {}, moving_balanced_, bias_.data());
  for (int j : joints_) {
    if (!active[m.jnt_body[j]]) continue;
    const int d = m.jnt_dof[j], q = m.jnt_qpos[j];
    const double K = joints.stiffness[j];
    auto act = [&](int i, double spring) {
      out[d + i] =
          h * (-bias_[d + i] - joints.damping[d + i] * qvel[d + i] + spring - h * K * qvel[d + i]);
    };
    switch (m.jnt_type[j]) {
      case Joint::Free:  // nothing to hold a spring
        for (int i = 0; i < 6; i++)
          out[d + i] = h * (-bias_[d + i] - joints.damping[d + i] * qvel[d + i]);
        break;
      case Joint::Ball: {
        const Quat rest = load4(&joints.spring[q]);
        const Vec3 off = log_quat(normalized(conjugate(rest) * load4(qpos + q)));
        for (int i = 0; i < 3; i++) act(i, -K * off[i]);
        break;
      }
      default: {
        if (effort_[j] == Effort::Within)
          act(0, asked(m, j, qpos));
        else  // at its effort a motor does not feel how far it is off
          out[d] = h * (driven_[j] - bias_[d]);
      }
    }
  }
}

void Articulations::limits(const Model& m, const std::vector<char>& active, const double* qpos,
                           std::vector<Contact>& out) const {
  out.clear();
  for (size_t i = 0; i < ends_.size(); i++) {
    const int j = end_joint_[i];
    if (!active[m.jnt_body[j]]) continue;
    out.push_back(ends_[i]);
    Contact& c = out.back();
    const double q = qpos[m.jnt_qpos[j]];
    c.dist = limit_sign(c) > 0 ? q - joints.lower[j] : joints.upper[j] - q;
    c.target = std::min(c.dist, tune::kLimitMargin);
  }
}

double Articulations::fastest(const Model& m, const std::vector<char>& active,
                              const double* qvel) const {
  double most = 0;
  for (int j : joints_) {
    if (!active[m.jnt_body[j]] || m.jnt_type[j] == Joint::Slide) continue;
    const double* v = qvel + m.jnt_dof[j];
    most = std::max(most, m.jnt_type[j] == Joint::Hinge  ? std::fabs(v[0])
                          : m.jnt_type[j] == Joint::Free ? norm(load3(v + 3))
                                                         : norm(load3(v)));
  }
  return most;
}

}  // namespace hp
