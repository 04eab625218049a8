// How far a shape moves as a body sees it: never less than its points do, and nothing of what both share.
#include "check.h"
#include "collision/relative_travel.h"
#include "small_person.h"

namespace {

// Of coordinates of some metres, through three rotations [m].
constexpr double rounding = 2e-14;

hp::Poses posed(const hp::System& system, const std::vector<double>& qpos) {
  hp::Poses p;
  p.kin.resize(system.model);
  p.kin.update(system.model, qpos.data());
  p.restart(system.world.shapes.size());
  return p;
}

// A vertex of a shape as a body sees it.
hp::Vec3 seen(const hp::CollisionShape& shape, int body, const hp::Poses& p, hp::Vec3 local) {
  const hp::Vec3 x = p.kin.xpos[shape.body] + p.kin.xmat[shape.body] * local;
  return mul_t(p.kin.xmat[body], x - p.kin.xpos[body]);
}

void bounds_every_vertex() {
  hp::Stepper s;
  small_person::build(s, 0.02);
  const hp::System& system = s.system;
  for (int k = 0; k < 20; k++) {
    const hp::Poses from = posed(system, small_person::pose(0.1 * k, 1)),
                    to = posed(system, small_person::pose(0.1 * k + 0.4, 1.2));
    for (const hp::CollisionShape& shape : system.world.shapes)
      for (int body = 1; body <= small_person::bodies; body++) {
        const double most = relative_travel(shape, body, from, to);
        for (hp::Vec3 v : shape.hull.vertices) {
          const hp::Vec3 way = seen(shape, body, to, v) - seen(shape, body, from, v);
          CHECK(norm(way) <= most + rounding);
        }
      }
  }
}

// Everybody is moved and turned as one: nobody sees anything move.
void sees_nothing_of_what_is_shared() {
  hp::Stepper s;
  small_person::build(s, 0.02);
  std::vector<double> start = small_person::pose(0.3, 1), end = start;
  const double half = 0.35;
  const hp::Quat turn{std::cos(half), 0, 0, std::sin(half)},
      root = turn * hp::Quat{start[3], start[4], start[5], start[6]};
  end[0] = 5, end[1] = -2, end[3] = root.w, end[4] = root.x, end[5] = root.y, end[6] = root.z;
  const hp::Poses from = posed(s.system, start), to = posed(s.system, end);
  for (const hp::CollisionShape& shape : s.system.world.shapes)
    for (int body = 1; body <= small_person::bodies; body++)
      CHECK(relative_travel(shape, body, from, to) <= rounding);
}

}  // namespace

int main() {
  bounds_every_vertex();
  sees_nothing_of_what_is_shared();
  return check::report("relative travel");
}
