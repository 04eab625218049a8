// Ways round what stands in between.
#include "footing/way_round.h"

#include <cmath>

#include "check.h"
#include "static_box.h"

namespace {

using hp::Vec3;
using static_box::world_of;
constexpr auto box = static_box::make;

constexpr double kDt = 1.0 / 30, kSpeed = 1.2;  // [s], [m/s]

// Distance from a box in the plane; 0 inside.
double apart(Vec3 x, Vec3 lo, Vec3 hi) {
  const double dx = std::max({lo.x - x.x, x.x - hi.x, 0.0}),
               dy = std::max({lo.y - x.y, x.y - hi.y, 0.0});
  return std::sqrt(dx * dx + dy * dy);
}

struct Walk {
  double length = 0, nearest = 1e300, left = 0;
};

Walk walk(const hp::CollisionWorld& world, Vec3 from, Vec3 to, Vec3 lo, Vec3 hi) {
  hp::WayRound way;
  Walk done;
  for (int i = 0; i < 300; i++) {
    const Vec3 next = way.next(world, from, to, 0, kDt);
    const Vec3 go{next.x - from.x, next.y - from.y, 0};
    const double size = hp::norm(go), step = std::min(size, kSpeed * kDt);
    if (size > 0) from += (step / size) * go;
    done.length += step;
    done.nearest = std::min(done.nearest, apart(from, lo, hi));
  }
  done.left = hp::norm(Vec3{to.x - from.x, to.y - from.y, 0});
  return done;
}

void a_table_is_gone_round_with_room_for_the_body() {
  const Vec3 lo{-0.4, -0.8, 0}, hi{0.4, 0.8, 0.75};
  for (bool mesh : {false, true}) {
    const hp::CollisionWorld world = world_of({box(lo, hi, mesh)});
    const Walk w = walk(world, {-1.2, 0.2, 0}, {1.2, 0.1, 0}, lo, hi);
    CHECK_NEAR(w.left, 0, 0.15);
    CHECK(w.nearest > 0.15);
    // Round two corners at 0.22 m from them it is 3.2 m.
    CHECK(w.length > 2.9 && w.length < 4.2);
  }
}

void where_nothing_is_in_between_it_goes_straight() {
  const Vec3 lo{-0.4, -0.8, 0}, hi{0.4, 0.8, 0.75};
  const hp::CollisionWorld world = world_of({box(lo, hi, false)});
  hp::WayRound way;
  const Vec3 to{1.0, 2.0, 0.5}, next = way.next(world, {-1, 2, 1}, to, 0, kDt);
  CHECK(next.x == to.x && next.y == to.y && !way.on());
}

// Whoever is a hundred metres away and more is not walked back: what is in between is not looked at.
void what_is_very_far_is_gone_to_straight() {
  const Vec3 lo{-0.4, -0.8, 0}, hi{0.4, 0.8, 0.75};
  const hp::CollisionWorld world = world_of({box(lo, hi, false)});
  for (double far : {150.0, 1e9}) {
    hp::WayRound way;
    const Vec3 to{far, 0.1, 0}, next = way.next(world, {-1.2, 0.2, 0}, to, 0, kDt);
    CHECK(next.x == to.x && next.y == to.y && !way.on());
  }
}

void what_one_steps_over_or_walks_under_is_not_in_the_way() {
  const hp::CollisionWorld step = world_of({box({-0.4, -0.8, 0}, {0.4, 0.8, 0.2}, false)});
  hp::WayRound over, under;
  over.next(step, {-1.2, 0, 0}, {1.2, 0, 0}, 0, kDt);
  CHECK(!over.on());
  const hp::CollisionWorld lamp = world_of({box({-0.4, -0.8, 1.9}, {0.4, 0.8, 2.2}, true)});
  under.next(lamp, {-1.2, 0, 0}, {1.2, 0, 0}, 0, kDt);
  CHECK(!under.on());
}

void who_stands_at_a_thing_leaves_it() {
  const Vec3 lo{-0.4, -0.8, 0}, hi{0.4, 0.8, 0.75};
  const hp::CollisionWorld world = world_of({box(lo, hi, false)});
  const Walk w = walk(world, {-0.5, 0, 0}, {1.2, 0, 0}, lo, hi);
  CHECK_NEAR(w.left, 0, 0.15);
}

void where_there_is_no_way_it_goes_as_near_as_it_can() {
  // Four walls around the goal.
  const hp::CollisionWorld world =
      world_of({box({0.5, -1, 0}, {0.6, 1, 2}, false), box({2.4, -1, 0}, {2.5, 1, 2}, false),
                box({0.5, -1.1, 0}, {2.5, -1, 2}, false), box({0.5, 1, 0}, {2.5, 1.1, 2}, false)});
  const Walk w = walk(world, {-1, 0, 0}, {1.5, 0, 0}, {0.5, -1.1, 0}, {2.5, 1.1, 0});
  CHECK(w.nearest > 0.1);
  CHECK(w.left > 0.9 && w.left < 1.5);
}

void saved_and_loaded_it_goes_on() {
  const Vec3 lo{-0.4, -0.8, 0}, hi{0.4, 0.8, 0.75};
  const hp::CollisionWorld world = world_of({box(lo, hi, false)});
  hp::WayRound a, b;
  a.next(world, {-1.2, 0.2, 0}, {1.2, 0.1, 0}, 0, kDt);
  CHECK(a.on());
  std::vector<double> saved;
  a.save(saved);
  CHECK(b.load(saved.data()) == saved.data() + saved.size());
  for (int i = 0; i < 30; i++) {
    const Vec3 at{-1.2, 0.2 + 0.03 * i, 0};
    const Vec3 x = a.next(world, at, {1.2, 0.1, 0}, 0, kDt);
    const Vec3 y = b.next(world, at, {1.2, 0.1, 0}, 0, kDt);
    CHECK(x.x == y.x && x.y == y.y);
  }
}

}  // namespace

int main() {
  a_table_is_gone_round_with_room_for_the_body();
  where_nothing_is_in_between_it_goes_straight();
  what_is_very_far_is_gone_to_straight();
  what_one_steps_over_or_walks_under_is_not_in_the_way();
  who_stands_at_a_thing_leaves_it();
  where_there_is_no_way_it_goes_as_near_as_it_can();
  saved_and_loaded_it_goes_on();
  return check::report("way_round");
}
