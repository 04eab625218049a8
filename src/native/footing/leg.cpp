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

Leg::Bent Leg::bend(const Kinematics& k, Vec3 shift) const {
  const Vec3 h = k.xpos[hip], from = k.xpos[ankle];
  const Vec3 u = k.xpos[knee] - h, w = from - k.xpos[knee];
  Vec3 to = from + shift - h;
  const double asked = norm(to), most = reach(k);
  if (asked > most) to = (most / asked) * to;
  const Vec3 n = knee_axis(u, k.xmat[hip].col(0));
  const Quat bend = exp_quat(knee_turn(u, w, n, norm(to)) * n);
  const Quat swing = least_rotation(u + rotate(bend, w), to);
  const Quat thigh = swing * k.xquat[hip], shank = swing * bend * k.xquat[knee];
  Bent b;
  b.hip = normalized(conjugate(k.xquat[root]) * thigh);
  b.knee = normalized(conjugate(thigh) * shank);
  b.ankle = normalized(conjugate(shank) * k.xquat[ankle]);
  b.foot = k.xquat[ankle];
  b.made = to + h - from;
  return b;
}

// Are hip and knee within their ranges?
bool Leg::holds(const Bent& b, const Bent& asked) const {
  const auto inside = [](const JointRange& r, Quat q, Quat own) {
    return norm(joint_angles(r, q) - clamped_angles(r, q, own)) < tune::kLegRangeMiss;
  };
  return inside(ranges[0], b.hip, asked.hip) && inside(ranges[1], b.knee, asked.knee);
}

// The largest part of a shift that hip and knee can make, and the ankle as far as it goes.
Leg::Bent Leg::within(const Kinematics& k, Vec3 shift, const Bent& asked) const {
  Bent b = bend(k, shift);
  if (!holds(b, asked)) {
    double good = 0, bad = 1;
    for (int i = 0; i < tune::kLegBisections; i++) {
      const double share = 0.5 * (good + bad);
      (holds(bend(k, share * shift), asked) ? good : bad) = share;
    }
    b = bend(k, good * shift);
  }
  const Vec3 angles = joint_angles(ranges[2], b.ankle),
             kept = clamped_angles(ranges[2], b.ankle, asked.ankle);
  if (norm(angles - kept) < tune::kLegRangeMiss) return b;
  const Quat ankle = normalized(from_joint_angles(ranges[2], kept));
  b.foot = b.foot * conjugate(b.ankle) * ankle;
  b.ankle = ankle;
  return b;
}

// How far a foot that tilts about its ankle comes down with a point of its sole [m].
double Leg::sinks(const Kinematics& k, const Bent& b) const {
  const Mat3 turn = to_matrix(b.foot * conjugate(k.xquat[ankle]));
  double most = 0;
  for (const SkinPoint& p : sole) {
    const Vec3 arm = p.position(k) - k.xpos[ankle];
    most = std::max(most, arm.z - (turn * arm).z);
  }
  return most;
}

Vec3 Leg::move(const Kinematics& k, Vec3 shift, double* qpos) const {
  Bent b;
  if (ranges.empty()) {
    b = bend(k, shift);
  } else {
    Bent asked;
    asked.hip = load4(qpos + hip_qpos), asked.knee = load4(qpos + knee_qpos);
    asked.ankle = load4(qpos + ankle_qpos);
    b = within(k, shift, asked);
    const Vec3 made = b.made;
    const double rise = sinks(k, b);
    if (rise > tune::kAtHeight) b = within(k, made + Vec3{0, 0, rise}, asked);
    b.made = made;
  }
  store4(qpos + hip_qpos, b.hip);
  store4(qpos + knee_qpos, b.knee);
  store4(qpos + ankle_qpos, b.ankle);
  return b.made;
}

}  // namespace hp
