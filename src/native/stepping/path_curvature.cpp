#include "stepping/path_curvature.h"

namespace hp {

namespace {

// The acceleration of a point whose tree keeps its joints' velocities.
Vec3 point_acceleration(const Model& m, const Kinematics& k, const std::vector<Twist>& velocity,
                        const std::vector<Twist>& acceleration, const Endpoint& e) {
  Vec3 out;
  for (int i = 0; i < e.count; i++) {
    const Twist &t = velocity[e.body[i]], &a = acceleration[e.body[i]];
    const Vec3 r = e.point[i] - k.reference(m, e.body[i]);
    out += e.weight[i] * (a.v + cross(a.w, r) + cross(t.w, t.v + cross(t.w, r)));
  }
  return out;
}

}  // namespace

void PathCurvature::begin(const System& system, const State& state) {
  body_twists(system.model, state.pose.kin, state.qvel.data(), velocity_);
  acceleration_.clear();
}

void PathCurvature::bend(const System& system, const State& state, const Attempt& attempt,
                         Contact& c) {
  const Model& model = system.model;
  const Kinematics& kin = state.pose.kin;
  auto body = [&](int shape) { return shape < 0 ? 0 : system.world.shapes[shape].body; };
  const ContactCandidate& k = attempt.candidates[c.pair];
  const int a = body(k.shape), b = body(k.other_shape);
  if (k.other_shape < 0 || system.is_person(a) == system.is_person(b) ||
      system.drive_settings.time_constant == 0 || system.prescribed != Prescribed::No)
    return;
  // Two bodies have one path past each other: points that differed would work against each other.
  for (const Contact& o : attempt.contacts) {
    const ContactCandidate& other = attempt.candidates[o.pair];
    if (&o == &c || body(other.shape) != a || body(other.other_shape) != b) continue;
    c.curve = o.curve;
    if (norm2(c.curve) > 0) return;
  }
  if (acceleration_.empty()) {
    acceleration_.resize(model.nbody);
    for (int i = 1; i < model.nbody; i++) {
      Twist velocity = velocity_[model.parent[i]];
      acceleration_[i] = acceleration_[model.parent[i]];
      carry(model, kin, state.qvel.data(), i, velocity, acceleration_[i]);
    }
  }
  c.curve = 0.5 * (point_acceleration(model, kin, velocity_, acceleration_, c.a) -
                   point_acceleration(model, kin, velocity_, acceleration_, c.b));
}

}  // namespace hp
