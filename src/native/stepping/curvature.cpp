// Ways that curve within a substep: what velocities alone would let a hand lose of what it holds.
#include "stepping/stepper.h"

namespace hp {

// The acceleration of a point whose tree keeps its joints' velocities.
static Vec3 acceleration(const Model& m, const Kinematics& k, const std::vector<Twist>& moving,
                         const std::vector<Twist>& turning, const Endpoint& e) {
  Vec3 out;
  for (int i = 0; i < e.count; i++) {
    const Twist &t = moving[e.body[i]], &a = turning[e.body[i]];
    const Vec3 r = e.point[i] - k.reference(m, e.body[i]);
    out += e.weight[i] * (a.v + cross(a.w, r) + cross(t.w, t.v + cross(t.w, r)));
  }
  return out;
}

void Stepper::bend_way(Contact& c) {
  auto body = [&](int shape) { return shape < 0 ? 0 : world.shapes[shape].body; };
  const ContactCandidate& k = candidates_[c.pair];
  const int a = body(k.shape), b = body(k.other_shape);
  // Only of a person and a thing: of two things, which nobody drives, neither has a way to keep to, and
  // both would gain energy. And not with Algorithm 1, which is as the paper has it,
  // nor of who is set somewhere and has no velocity there.
  if (k.other_shape < 0 || is_person(a) == is_person(b) || drive_settings.time_constant == 0 ||
      forced != Forced::No)
    return;
  // Two bodies have one way past each other: points that differed would work against each other.
  for (const Contact& o : contacts_) {
    const ContactCandidate& other = candidates_[o.pair];
    if (&o == &c || body(other.shape) != a || body(other.other_shape) != b) continue;
    c.curve = o.curve;
    if (norm2(c.curve) > 0) return;
  }
  if (turning_.empty()) {
    // At the velocities of the substep before: what the drive asks of fingers that squeeze does not
    // happen.
    turning_.resize(model.nbody);
    for (int b = 1; b < model.nbody; b++) {
      Twist velocity = moving_[model.parent[b]];
      turning_[b] = turning_[model.parent[b]];
      carry(model, start_.kin, qvel_.data(), b, velocity, turning_[b]);
    }
  }
  c.curve = 0.5 * (acceleration(model, start_.kin, moving_, turning_, c.a) -
                   acceleration(model, start_.kin, moving_, turning_, c.b));
}

}  // namespace hp
