#include "footing/leg.h"

#include "tuning.h"

namespace hp {

namespace tune = tuning::footing;

namespace {

// The least rotation that turns the direction of `from` into that of `to`.
Quat least_rotation(Vec3 from, Vec3 to) {
  const Vec3 axis = cross(from, to);
  const double w = dot(from, to) + std::sqrt(norm2(from) * norm2(to));
  if (w <= 1e-12 * norm(from) * norm(to)) return {};
  return normalized({w, axis.x, axis.y, axis.z});
}

Vec3 rotate(Quat q, Vec3 v) { return to_matrix(q) * v; }

// The axis about which the knee bends: the thigh's lateral, across the thigh u.
Vec3 knee_axis(Vec3 u, Vec3 own) {
  const Vec3 along = (1 / norm(u)) * u;
  const Vec3 n = own - dot(own, along) * along;
  const double size = norm(n);
  return size > 0 ? (1 / size) * n : own;
}

// The angle delta by which w is to turn about n, so that |u + w| is `distance`.
double knee_turn(Vec3 u, Vec3 w, Vec3 n, double distance) {
  const Vec3 across = w - dot(w, n) * n;
  const double even = norm2(u) + norm2(w) + 2 * dot(u, w - across);
  const double a = 2 * dot(u, across), b = 2 * dot(u, cross(n, across));
  const double size = std::sqrt(a * a + b * b);
  if (size == 0) return 0;
  const double middle = std::atan2(b, a);
  const double half = std::acos(std::clamp((distance * distance - even) / size, -1.0, 1.0));
  return middle + half;  // the other solution bends the knee forward
}

}  // namespace

double Leg::reach(const Kinematics& k) const {
  const Vec3 h = k.xpos[hip], n = k.xpos[knee], a = k.xpos[ankle];
  return std::max(norm(a - h), tune::kLegReach * (norm(n - h) + norm(a - n)));
}

double Leg::slack(const Kinematics& k) const {
  const Vec3 way = k.xpos[ankle] - k.xpos[hip];
  const double most = reach(k), across2 = way.x * way.x + way.y * way.y;
  return std::max(0.0, std::sqrt(std::max(0.0, most * most - across2)) + way.z);
}

Vec3 Leg::move(const Kinematics& k, Vec3 shift, double* qpos) const {
  const Vec3 h = k.xpos[hip], from = k.xpos[ankle];
  const Vec3 u = k.xpos[knee] - h, w = from - k.xpos[knee];
  Vec3 to = from + shift - h;
  const double asked = norm(to), most = reach(k);
  if (asked > most) to = (most / asked) * to;
  const Vec3 n = knee_axis(u, k.xmat[hip].col(0));
  const Quat bend = exp_quat(knee_turn(u, w, n, norm(to)) * n);
  const Quat swing = least_rotation(u + rotate(bend, w), to);
  const Quat thigh = swing * k.xquat[hip], shank = swing * bend * k.xquat[knee];
  store4(qpos + hip_qpos, normalized(conjugate(k.xquat[root]) * thigh));
  store4(qpos + knee_qpos, normalized(conjugate(thigh) * shank));
  store4(qpos + ankle_qpos, normalized(conjugate(shank) * k.xquat[ankle]));
  return to + h - from;
}

}  // namespace hp
