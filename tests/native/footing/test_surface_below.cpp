// What is under a point.
#include "footing/surface_below.h"

#include <cmath>

#include "check.h"
#include "static_box.h"

namespace {

using hp::Vec3;
using static_box::world_of;
constexpr auto box = static_box::make;

void a_slope_is_as_high_as_its_plane_and_a_wall_is_no_ground() {
  for (double angle : {0.0, 0.3, 0.9}) {
    const hp::CollisionWorld world = world_of({}, {std::sin(angle), 0, std::cos(angle)});
    const hp::Surface s = hp::SurfaceBelow(world).find_static({0.5, 2, 1}, 0.25, 3);
    CHECK(s.found);
    CHECK_NEAR(s.height, -0.5 * std::tan(angle), 1e-12);
  }
  const hp::CollisionWorld steep = world_of({}, {std::sin(1.2), 0, std::cos(1.2)});
  CHECK(!hp::SurfaceBelow(steep).find_static({0.5, 2, 1}, 0.25, 3).found);
}

void the_highest_top_within_a_step_counts() {
  for (bool mesh : {false, true}) {
    const hp::CollisionWorld world = world_of(
        {box({-1, -1, 0}, {1, 1, 0.1}, mesh), box({-0.5, -0.5, 0.1}, {0.5, 0.5, 0.2}, mesh)});
    hp::SurfaceBelow below(world);
    CHECK_NEAR(below.find_static({0, 0, 0.05}, 0.25, 3).height, 0.2, 1e-6);
    CHECK_NEAR(below.find_static({0.8, 0, 0.05}, 0.25, 3).height, 0.1, 1e-6);
    CHECK_NEAR(below.find_static({0, 0, 1.5}, 0.25, 3).height, 0.2, 1e-6);
    CHECK_NEAR(below.find_static({1.2, 0, 0.05}, 0.25, 3).height, 0, 1e-12);
    CHECK(!below.find_static({1.2, 0, 5}, 0.25, 3).found);
  }
}

void nobody_steps_on_a_bar_but_on_the_corner_of_a_stair() {
  hp::Poses poses;
  for (bool mesh : {false, true}) {
    const hp::CollisionWorld bar = world_of({box({-1, -0.02, 0.1}, {1, 0.02, 0.2}, mesh)});
    hp::SurfaceBelow under(bar);
    CHECK_NEAR(under.find(poses, {0, 0, 0.01}, 0.25, 3).height, 0.2, 1e-6);
    CHECK_NEAR(under.find_footing(poses, {0, 0, 0.01}, 0.25, 3).height, 0, 1e-12);
    // Who is on it already stays there.
    CHECK_NEAR(under.find_footing(poses, {0, 0, 0.19}, 0.25, 3).height, 0.2, 1e-6);
    const hp::CollisionWorld stair = world_of({box({0, 0, 0}, {1, 1, 0.2}, mesh)});
    CHECK_NEAR(hp::SurfaceBelow(stair).find_footing(poses, {0.01, 0.01, 0.01}, 0.25, 3).height, 0.2,
               1e-6);
  }
}

}  // namespace

int main() {
  a_slope_is_as_high_as_its_plane_and_a_wall_is_no_ground();
  the_highest_top_within_a_step_counts();
  nobody_steps_on_a_bar_but_on_the_corner_of_a_stair();
  return check::report("surface_below");
}
