#include "collision/relative_travel.h"

#include <cstdint>

namespace hp {

namespace {

// What an object sees of bodies between two poses, found when it is asked for.
struct Seen {
  int object = -1;
  uint64_t from = 0, to = 0;  // the poses' stamps
  // Per body: the travel of its origin [m], negative if unknown; 2 sin(angle / 2) of its rotation.
  std::vector<double> step, chord;

  void begin(int body, const Poses& a, const Poses& b) {
    if (object == body && from == a.stamp && to == b.stamp) return;
    object = body, from = a.stamp, to = b.stamp;
    step.assign(a.kin.xpos.size(), -1);
    chord.resize(step.size());
  }
  void find(int body, const Kinematics& a, const Kinematics& b) {
    if (step[body] >= 0) return;
    step[body] = norm(way(a, b, a.xpos[body], b.xpos[body]));
    // From the vector part, which is exact for rotations however small: they add up step by step.
    const Quat turn = conjugate(conjugate(a.xquat[object]) * a.xquat[body]) *
                      (conjugate(b.xquat[object]) * b.xquat[body]);
    chord[body] = 2 * norm(Vec3{turn.x, turn.y, turn.z});
  }
  Vec3 way(const Kinematics& a, const Kinematics& b, Vec3 x, Vec3 y) const {
    return mul_t(b.xmat[object], y - b.xpos[object]) - mul_t(a.xmat[object], x - a.xpos[object]);
  }
};

}  // namespace

double relative_travel(const CollisionShape& shape, int body, const Poses& from, const Poses& to) {
  if (!shape.blend_bounds.empty()) return kNoBound;
  static thread_local Seen seen;
  const Kinematics &a = from.kin, &b = to.kin;
  seen.begin(body, from, to);
  if (!shape.skin) {
    const int own = shape.body;
    const Vec3 c = shape.hull.center;
    seen.find(own, a, b);
    return norm(seen.way(a, b, a.xpos[own] + a.xmat[own] * c, b.xpos[own] + b.xmat[own] * c)) +
           seen.chord[own] * shape.hull.bound;
  }
  return shape.weighted_bound([&](const CollisionShape::Influence& t) {
    seen.find(t.body, a, b);
    return seen.step[t.body] + seen.chord[t.body] * t.reach;
  });
}

void forget_shared_travel(const CollisionWorld& world, std::vector<BroadPhasePair>& pairs,
                          const Poses& from, const Poses& to, const std::vector<double>& way) {
  for (BroadPhasePair& e : pairs) {
    if (e.other_shape < 0 || e.own || e.dist == BroadPhasePair::kUnknown) continue;
    const double shared = way[e.shape] + way[e.other_shape] - pair_travel(world, e, from, to, way);
    e.travelled += shared;
    e.room_at += shared;
  }
}

}  // namespace hp
