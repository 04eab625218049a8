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
  const double middle = elementary::atan2(b, a);
  const double half = elementary::acos(std::clamp((distance * distance - even) / size, -1.0, 1.0));
  return middle + half;  // the other solution bends the knee forward
}

}  // namespace

double Leg::reach(const Kinematics& k) const {
  const Vec3 h = k.xpos[hip], n = k.xpos[knee], a = k.xpos[ankle];
  return std::max(norm(a - h), tune::kLegReach * (norm(n - h) + norm(a - n)));
}

double Leg::slack(const Kinematics& k, Vec3 shift) const {
  const Vec3 way = k.xpos[ankle] - k.xpos[hip];
  const double x = way.x + shift.x, y = way.y + shift.y;
  const double most = reach(k), across2 = x * x + y * y;
  const double slack = std::sqrt(std::max(0.0, most * most - across2)) + way.z;
  return shift.x == 0 && shift.y == 0 ? std::max(0.0, slack) : slack;
}

Leg::Bent Leg::bend(const Kinematics& k, const Place& place, const Bent& asked_joints) const {
  const Vec3 h = k.xpos[hip];
  const Vec3 u = k.xpos[knee] - h;
  Vec3 to = place.ankle - h;
  const double asked = norm(to), most = reach(k);
  if (asked > most) to = (most / asked) * to;
  const Vec3 n = knee_axis(u, k.xmat[hip].col(0));
  Quat from;  // turns the shank before it bends
  Vec3 w = k.xpos[ankle] - k.xpos[knee];
  Quat bend = exp_quat(knee_turn(u, w, n, norm(to)) * n);
  // What a knee cannot turn aside it does not, and bends by a little more or less.
  for (int i = 0; i < tune::kKneeTries && !ranges.empty(); i++) {
    const Quat joint = conjugate(k.xquat[hip]) * bend * from * k.xquat[knee];
    const Vec3 kept = clamped_angles(ranges[1], joint, asked_joints.knee);
    if (norm(joint_angles(ranges[1], joint) - kept) < tune::kLegRangeMiss) break;
    from = k.xquat[hip] * from_joint_angles(ranges[1], kept) * conjugate(k.xquat[knee]);
    w = rotate(from, k.xpos[ankle] - k.xpos[knee]);
    bend = exp_quat(knee_turn(u, w, n, norm(to)) * n);
  }
  const Quat swing = least_rotation(u + rotate(bend, w), to);
  const Quat thigh = swing * k.xquat[hip], shank = swing * bend * from * k.xquat[knee];
  Bent b;
  b.hip = normalized(conjugate(k.xquat[root]) * thigh);
  b.knee = normalized(conjugate(thigh) * shank);
  b.ankle = normalized(conjugate(shank) * place.foot);
  b.foot = {to + h, place.foot};
  return b;
}

// Are hip and knee within their ranges?
bool Leg::holds(const Bent& b, const Bent& asked) const {
  const auto inside = [](const JointRange& r, Quat q, Quat own) {
    return norm(joint_angles(r, q) - clamped_angles(r, q, own)) < tune::kLegRangeMiss;
  };
  return inside(ranges[0], b.hip, asked.hip) && inside(ranges[1], b.knee, asked.knee);
}

// The largest part of the way to a place that hip and knee can make, and the ankle as far as it goes.
Leg::Bent Leg::within(const Kinematics& k, const Place& place, const Bent& asked) const {
  Bent b = bend(k, place, asked);
  if (!holds(b, asked)) {
    const Vec3 from = k.xpos[ankle], way = place.ankle - from;
    double good = 0, bad = 1;
    for (int i = 0; i < tune::kLegBisections; i++) {
      const double share = 0.5 * (good + bad);
      (holds(bend(k, {from + share * way, place.foot}, asked), asked) ? good : bad) = share;
    }
    b = bend(k, {from + good * way, place.foot}, asked);
  }
  const Vec3 angles = joint_angles(ranges[2], b.ankle),
             kept = clamped_angles(ranges[2], b.ankle, asked.ankle);
  if (norm(angles - kept) < tune::kLegRangeMiss) return b;
  const Quat ankle = normalized(from_joint_angles(ranges[2], kept));
  b.foot.foot = b.foot.foot * conjugate(b.ankle) * ankle;
  b.ankle = ankle;
  return b;
}

// How far a foot that is not turned as `asked` comes down into the ground with a point of its sole [m].
double Leg::sinks(const Kinematics& k, const Place& made, Quat asked,
                  const std::vector<double>& ground) const {
  const Quat own = conjugate(k.xquat[ankle]);
  const Mat3 level = to_matrix(asked * own), tilted = to_matrix(made.foot * own);
  double most = 0;
  for (size_t i = 0; i < sole.size(); i++) {
    const Vec3 arm = sole[i].position(k) - k.xpos[ankle];
    const double height = made.ankle.z + (tilted * arm).z;
    most = std::max(most, std::min((level * arm).z - (tilted * arm).z, ground[i] - height));
  }
  return most;
}

Vec3 Leg::move(const Kinematics& k, const Place& place, const std::vector<double>& ground,
               double* qpos) const {
  Bent b;
  Vec3 made;
  if (ranges.empty()) {
    b = bend(k, place, {});
    made = b.foot.ankle;
  } else {
    Bent asked;
    asked.hip = load4(qpos + hip_qpos), asked.knee = load4(qpos + knee_qpos);
    asked.ankle = load4(qpos + ankle_qpos);
    b = within(k, place, asked);
    made = b.foot.ankle;
    const double rise = sinks(k, b.foot, place.foot, ground);
    if (rise > tune::kAtHeight) b = within(k, {made + Vec3{0, 0, rise}, place.foot}, asked);
  }
  store4(qpos + hip_qpos, b.hip);
  store4(qpos + knee_qpos, b.knee);
  store4(qpos + ankle_qpos, b.ankle);
  return made;
}

}  // namespace hp
