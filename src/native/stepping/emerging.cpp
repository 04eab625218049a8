// A step of somebody who comes out of something that the person started inside: as fast as throws nobody.
#include "stepping/stepper.h"

namespace hp {

namespace {

// Nobody is thrown by what comes out of something faster than this [m/s]; it then comes out more slowly,
// by so many tries, and gains speed again by this factor a substep.
constexpr double kHurl = 0.85, kRegain = 1.3;
constexpr int kSlower = 4;

}  // namespace

double Stepper::hurled() {
  // What the motion asks; objects have none of their own.
  std::vector<double> asked(v_free_);
  for (const Drive& d : drives_) d.reference(asked.data());
  std::vector<Twist> own;
  body_twists(model, start_.kin, v_.data(), twists_);
  body_twists(model, start_.kin, asked.data(), own);
  std::vector<char> tree(model.nbody, 0);
  for (const Inside& in : world.inside()) tree[model.root[world.shapes[in.shape].body]] = 1;
  double fastest = 0;
  for (size_t i = 0; i < world.shapes.size(); i++) {
    const CollisionShape& m = world.shapes[i];
    if (!tree[model.root[m.body]] || !world.active[m.body]) continue;
    if (speed_bound(m, twists_) <= fastest) continue;
    const Points p = world.place(start_, (int)i).points();
    const size_t n = p.n;
    for (size_t k = 0; k < n; k++) {
      auto speed = [&](const std::vector<Twist>& twists) {
        Vec3 v;
        for (size_t t = 0; t < m.ties.size(); t++) {
          const double w = m.skin ? m.weights[t * n + k] : 1;
          if (w == 0) continue;
          const Twist& body = twists[m.ties[t].body];
          v += w * (body.v + cross(body.w, p.at((int)k) - start_.kin.reference(model, m.body)));
        }
        return norm(v);
      };
      fastest = std::max(fastest, speed(twists_) - speed(own));
    }
  }
  return fastest;
}

// A step of length h. Whoever comes out of something does so more slowly where that would throw
// somebody or does not go with what else is asked; not at all, if need be.
void Stepper::emerge(double h) {
  if (!world.any_inside()) return try_step(h);
  world.growth = std::min(1.0, kRegain * world.growth);
  for (int k = 0; k < kSlower; k++) {
    try_step(h);
    const double speed = hurled();
    if (good_ && speed <= kHurl) return;
    const double slower = speed > kHurl ? 0.9 * kHurl / speed : 0.3;
    world.growth *= std::max(0.1, slower);
  }
  const double kept = world.growth;
  world.growth = 0;
  try_step(h);
  world.growth = kept;
}

}  // namespace hp
