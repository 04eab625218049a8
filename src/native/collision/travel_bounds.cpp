#include "collision/travel_bounds.h"

#include <cmath>

namespace hp {

namespace {

// 2 sin(angle / 2) of the rotation from p to q: how far it moves a point at distance 1.
double rotation_chord(Quat p, Quat q) {
  const Quat turn = conjugate(p) * q;
  return 2 * norm(Vec3{turn.x, turn.y, turn.z});  // its cosine tells nothing of angles under 1e-8
}

// Per joint, the Frobenius norm of the change of its local rotation matrix between two poses.
void local_changes(const Skin& s, const Kinematics& from, const Kinematics& to,
                   std::vector<double>& change) {
  change.assign(s.joint.size(), 0);
  for (size_t j = 1; j < s.joint.size(); j++) {
    auto local = [&](const Kinematics& kin) {
      return conjugate(kin.xquat[s.body[s.parent[j]]]) * kin.xquat[s.body[j]];
    };
    change[j] = std::sqrt(2.0) * rotation_chord(local(from), local(to));
  }
}

}  // namespace

void travel_bounds(const std::vector<CollisionShape>& shapes, const Poses& from, const Poses& to,
                   const std::vector<char>& active, std::vector<double>& travel) {
  const int bodies = (int)from.kin.xpos.size();
  // Per body: rotation chord; origin's displacement; of joints the change of the local matrix.
  static thread_local std::vector<double> scratch[3];
  for (int k = 0; k < 2; k++) scratch[k].resize(bodies);
  double *turn = scratch[0].data(), *step = scratch[1].data();
  std::vector<double>& change = scratch[2];
  for (int b = 1; b < bodies; b++) {
    if (!active[b]) continue;
    turn[b] = rotation_chord(from.kin.xquat[b], to.kin.xquat[b]);
    step[b] = norm(to.kin.xpos[b] - from.kin.xpos[b]);
  }
  const Skin* known = nullptr;
  travel.resize(shapes.size());
  for (size_t i = 0; i < shapes.size(); i++) {
    const CollisionShape& m = shapes[i];
    if (!active[m.body]) {
      travel[i] = 0;
      continue;
    }
    if (!m.skin) {
      const Vec3 c = m.hull.center;
      const Vec3 a = from.kin.xpos[m.body] + from.kin.xmat[m.body] * c,
                 b = to.kin.xpos[m.body] + to.kin.xmat[m.body] * c;
      travel[i] = norm(b - a) + turn[m.body] * m.hull.bound;
      continue;
    }
    travel[i] = m.weighted_bound(
        [&](const CollisionShape::Influence& t) { return step[t.body] + turn[t.body] * t.reach; });
    if (m.blend_bounds.empty()) continue;
    if (known != m.skin.get()) {
      known = m.skin.get();
      local_changes(*known, from.kin, to.kin, change);
    }
    for (const CollisionShape::BlendBound& e : m.blend_bounds)
      travel[i] += e.gain * change[e.joint];
  }
}

void travel_bounds_in_root_frame(const std::vector<CollisionShape>& shapes, const Model& m,
                                 const Poses& from, const Poses& to,
                                 const std::vector<char>& active, std::vector<double>& travel) {
  static thread_local Poses local[2];
  const Poses* poses[2] = {&from, &to};
  for (int k = 0; k < 2; k++) {
    const Kinematics& kin = poses[k]->kin;
    Kinematics& out = local[k].kin;
    out.xpos.resize(m.nbody), out.xquat.resize(m.nbody), out.xmat.resize(m.nbody);
    for (int b = 1; b < m.nbody; b++) {
      const int r = m.root[b];
      if (!active[b]) continue;
      out.xpos[b] = mul_t(kin.xmat[r], kin.xpos[b] - kin.xpos[r]);
      out.xquat[b] = conjugate(kin.xquat[r]) * kin.xquat[b];
      out.xmat[b] = transposed(kin.xmat[r]) * kin.xmat[b];
    }
  }
  travel_bounds(shapes, local[0], local[1], active, travel);
}

}  // namespace hp
