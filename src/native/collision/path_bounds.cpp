#include "collision/path_bounds.h"

#include <cmath>

namespace hp {

namespace {

// The angle of the rotation from p to q.
double angle_between(Quat p, Quat q) {
  const double cosine = std::fabs(p.w * q.w + p.x * q.x + p.y * q.y + p.z * q.z);
  return 2 * elementary::asin(std::sqrt(std::max(0.0, 1 - std::min(1.0, cosine * cosine))));
}

}  // namespace

void PathBounds::add_joint(const Model& m, int j, const double* way, int b) {
  double &S = spin_[b], &B = turn_[b], &A = acceleration_[b];
  if (m.jnt_type[j] == Joint::Free) {
    S = angle_[b] = norm(load3(way + 3));
  } else if (m.jnt_type[j] == Joint::Slide) {
    A += (2 * S + S * S + B) * std::fabs(way[0]);
  } else {
    const double arm = norm(m.jnt_pos[j]),
                 angle = m.jnt_type[j] == Joint::Ball ? norm(load3(way)) : std::fabs(way[0]);
    A += (S * S + B) * arm;
    B += S * angle;
    S += angle;
    angle_[b] += angle;
    A += (S * S + B) * arm;
  }
}

void PathBounds::find(const Model& m, const Kinematics& from, const Kinematics& to,
                      const std::vector<double>& way) {
  for (auto* v : {&angle_, &spin_, &turn_, &acceleration_}) v->assign(m.nbody, 0);
  for (int b = 1; b < m.nbody; b++) {
    const int p = m.parent[b];
    spin_[b] = spin_[p], turn_[b] = turn_[p];
    acceleration_[b] =
        acceleration(p, std::max(norm(from.xpos[b] - from.xpos[p]), norm(to.xpos[b] - to.xpos[p])));
    for (int j = m.jnt_first[b]; j < m.jnt_first[b] + m.jnt_count[b]; j++)
      add_joint(m, j, &way[m.jnt_dof[j]], b);
    // Rotations about several axes may go together to less; of more than half a turn one sees only
    // the rest of a turn.
    if (spin_[b] < M_PI)
      spin_[b] = std::min(spin_[b], angle_between(from.xquat[b], to.xquat[b]) + turn_[b]);
  }
}

double PathBounds::acceleration(const CollisionShape& shape) const {
  double most = shape.weighted_bound([&](const CollisionShape::Influence& t) {
    return acceleration(t.body, norm(t.anchor) + t.reach);
  });
  if (shape.blend_bounds.empty()) return most;
  // Blend shapes move the points in frames that turn.
  double speed = 0, rate = 0, spin = 0;
  for (const CollisionShape::BlendBound& e : shape.blend_bounds) {
    const int b = shape.skin->body[e.joint];
    const double angle = angle_[b];
    speed += std::sqrt(2.0) * e.gain * angle, rate += std::sqrt(2.0) * e.gain * angle * angle;
  }
  for (const CollisionShape::Influence& t : shape.influences) spin = std::max(spin, spin_[t.body]);
  return most + rate + 2 * spin * speed;
}

}  // namespace hp
