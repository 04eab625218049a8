// Feet that keep their places, and step.
#include "footing/footwork.h"

#include <cmath>

#include "check.h"

namespace {

using hp::Footwork;
using hp::Vec3;

constexpr double kDt = 1.0 / 60;
const Footwork::Lands kAnywhere = [](size_t, Vec3, double) { return true; };

// Two feet that have stood for a second.
std::vector<Footwork::Foot> standing(Vec3 slid = {}) {
  Footwork::Foot foot;
  foot.rests = 1, foot.rested = 1, foot.grounded = foot.stands = true;
  foot.slid = slid;
  return {foot, foot};
}

void a_foot_keeps_its_place_while_the_body_is_moved() {
  Footwork feet;
  feet.clear(2);
  Vec3 moved;
  for (int i = 0; i < 30; i++) {
    const Vec3 slid{0.001, -0.0005, 0};
    moved += slid;
    feet.frame(standing(slid), false, kDt, kAnywhere);
    for (size_t f = 0; f < 2; f++) CHECK_NEAR(hp::norm(feet.offset(f) + moved), 0, 1e-12);
  }
}

// Somebody is moved aside by 0.48 m in a second: where the feet are in the world, frame by frame.
struct Story {
  std::vector<Vec3> place[2];
  std::vector<double> raised[2];
  Footwork feet;
};

Story moved_aside(const Footwork::Lands& lands) {
  Story story;
  story.feet.clear(2);
  Vec3 body;
  for (int i = 0; i < 180; i++) {
    const Vec3 slid = i < 60 ? Vec3{0, 0.008, 0} : Vec3{};
    body += slid;
    story.feet.frame(standing(slid), true, kDt, lands);
    for (size_t f = 0; f < 2; f++) {
      story.place[f].push_back(body + story.feet.offset(f));
      story.raised[f].push_back(story.feet.raised(f));
    }
  }
  return story;
}

void who_is_moved_aside_steps_with_one_foot_at_a_time_and_slides_not_at_all() {
  const Story s = moved_aside(kAnywhere);
  int steps = 0;
  for (size_t i = 1; i < s.place[0].size(); i++) {
    CHECK(s.raised[0][i] == 0 || s.raised[1][i] == 0);
    for (int f = 0; f < 2; f++) {
      const bool up = s.raised[f][i] > 0 || s.raised[f][i - 1] > 0;
      steps += s.raised[f][i] > 0 && s.raised[f][i - 1] == 0;
      const double went = hp::norm(s.place[f][i] - s.place[f][i - 1]);
      if (!up) CHECK_NEAR(went, 0, 1e-12);
      CHECK(went < 6 * kDt);  // [m], of who takes a quick step
      CHECK(s.raised[f][i] < 0.05);
    }
  }
  CHECK(steps >= 4);
  for (int f = 0; f < 2; f++)  // they are where they belong, but for what is not worth a step
    CHECK_NEAR(hp::norm(s.place[f].back() - Vec3{0, 0.48, 0}), 0, 0.04);
}

void a_foot_steps_only_where_there_is_ground_and_then_shorter() {
  const Story none = moved_aside([](size_t, Vec3, double) { return false; });
  for (int f = 0; f < 2; f++)
    for (double r : none.raised[f]) CHECK(r == 0);
  // 0.2 m are left of its way, with a hole from the third quarter on: it takes two quarters, and none after that.
  Footwork feet;
  feet.clear(2);
  for (int i = 0; i < 20; i++) feet.frame(standing({0, 0.01, 0}), false, kDt, kAnywhere);
  for (int i = 0; i < 60; i++) feet.frame(standing(), false, kDt, kAnywhere);  // it comes to rest
  const auto hole = [](size_t, Vec3 to, double) { return to.y < -0.06; };
  for (int i = 0; i < 120; i++) {
    feet.frame(standing(), true, kDt, hole);
    for (size_t f = 0; f < 2; f++) CHECK(feet.offset(f).y < -0.06);
  }
  for (size_t f = 0; f < 2; f++) CHECK(feet.offset(f).y > -0.11);
}

void a_foot_is_not_lifted_while_the_other_does_not_stand() {
  Footwork feet;
  feet.clear(2);
  for (int i = 0; i < 60; i++) {
    auto both = standing({0, 0.005, 0});
    both[0].rested = both[1].rested = 0.4;
    both[1].stands = false;
    feet.frame(both, true, kDt, kAnywhere);
    CHECK(!feet.steps(0) && !feet.steps(1));
  }
}

// A leg that does not reach the ground behind the body would be dragged along for ever.
void a_foot_that_hangs_behind_steps_unless_something_keeps_it() {
  for (const bool kept : {false, true}) {
    Footwork feet;
    feet.clear(2);
    bool stepped = false;
    for (int i = 0; i < 60; i++) {
      auto both = standing({0, 0.005, 0});
      both[1].stands = false;
      if (kept) both[1].missed = {0, -0.05, 0};
      feet.frame(both, true, kDt, kAnywhere);
      CHECK(!feet.steps(0));
      if (feet.steps(1) && !stepped) CHECK(feet.offset(1).y < -0.2);
      stepped |= feet.steps(1);
    }
    CHECK(stepped == !kept);
  }
}

void who_waits_leaves_a_foot_that_was_stopped_where_it_is() {
  Footwork feet;
  feet.clear(2);
  feet.frame(standing(), true, kDt, kAnywhere);
  auto both = standing();
  both[0].missed = {-0.1, 0, 0};
  feet.frame(both, true, kDt, kAnywhere);
  CHECK(!feet.stopped(0) && feet.offset(0).x == 0);  // who does not wait comes back to its place
  for (auto& foot : both) foot.held = true;
  feet.frame(both, true, kDt, kAnywhere);
  CHECK(feet.stopped(0));
  CHECK_NEAR(feet.offset(0).x, -0.1, 1e-15);
  both[0].missed = {};
  for (int i = 0; i < 60; i++) feet.frame(both, true, kDt, kAnywhere);
  CHECK_NEAR(feet.offset(0).x, -0.1, 1e-15);  // that is its place, it does not step
  both[0].missed = {-2, 0, 0};
  feet.frame(both, true, kDt, kAnywhere);
  CHECK_NEAR(feet.offset(0).x, -0.1, 1e-15);  // no leg reaches so far
}

void a_body_slows_down_where_its_feet_cannot_follow() {
  Footwork feet;
  feet.clear(2);
  CHECK(feet.pace({1, 0, 0}) == 1);
  for (int i = 0; i < 20; i++) feet.frame(standing({0.01, 0, 0}), false, kDt, kAnywhere);
  CHECK(feet.pace({1, 0, 0}) < 0.6);
  CHECK(feet.pace({-1, 0, 0}) == 1);
  for (int i = 0; i < 100; i++) feet.frame(standing({0.01, 0, 0}), false, kDt, kAnywhere);
  CHECK(feet.pace({1, 0, 0}) > 0);
  CHECK(hp::norm(feet.offset(0)) < 0.26);  // then it slides
}

void what_a_motion_lifts_comes_back_to_its_place() {
  Footwork feet;
  feet.clear(2);
  for (int i = 0; i < 20; i++) feet.frame(standing({0.01, 0, 0}), false, kDt, kAnywhere);
  auto walking = standing();
  for (auto& foot : walking) foot.rests = 0, foot.stands = false;
  for (int i = 0; i < 120; i++) feet.frame(walking, true, kDt, kAnywhere);
  for (size_t f = 0; f < 2; f++)  // to the bit
    CHECK(feet.offset(f).x == 0 && feet.offset(f).y == 0 && feet.turn(f) == 0);
}

// A leg that reaches no nearer than 12 cm to where it is to be: a step or two, and then it stands.
void who_waits_stands_where_its_step_has_ended() {
  Footwork feet;
  feet.clear(2);
  auto both = standing();
  for (auto& foot : both) foot.held = true;
  feet.frame(both, true, kDt, kAnywhere);
  int steps = 0;
  for (int i = 0; i < 240; i++) {
    const bool up = feet.raised(0) > 0 || feet.raised(1) > 0;
    both = standing({i < 30 ? 0.004 : 0.0, 0, 0});
    for (auto& foot : both) foot.held = true;
    feet.frame(both, true, kDt, kAnywhere);
    const Vec3 left = feet.offset(0);
    if (left.x > -0.12) feet.reached(0, {-0.12, 0, 0});
    steps += !up && (feet.raised(0) > 0 || feet.raised(1) > 0);
    if (i >= 120) CHECK(feet.raised(0) == 0 && feet.raised(1) == 0);
  }
  CHECK(steps >= 1 && steps <= 3);
}

void a_shorter_step_ends_where_there_is_ground_at_any_frame_rate() {
  Vec3 ground;
  const Footwork::Lands lands = [&](size_t, Vec3 at, double) {
    ground = at;
    return at.y < -0.149;
  };
  for (double fps : {10.0, 30.0, 60.0, 240.0}) {
    Footwork feet;
    feet.clear(2);
    feet.reached(0, {0, -0.3, 0});
    feet.frame(standing(), true, 1 / fps, lands);
    CHECK(feet.steps(0));
    while (feet.steps(0)) feet.frame(standing(), false, 1 / fps, lands);
    CHECK_NEAR(feet.offset(0).y, ground.y, 1e-9);
  }
}

void saved_and_loaded_it_goes_on() {
  Footwork a, b;
  a.clear(2);
  for (int i = 0; i < 40; i++) a.frame(standing({0, 0.01, 0}), true, kDt, kAnywhere);
  CHECK(a.steps(0) || a.steps(1));
  std::vector<double> saved;
  a.save(saved);
  CHECK(b.load(saved.data(), 2) == saved.data() + saved.size());
  for (int i = 0; i < 60; i++) {
    a.frame(standing({0, 0.002, 0}), true, kDt, kAnywhere);
    b.frame(standing({0, 0.002, 0}), true, kDt, kAnywhere);
    for (size_t f = 0; f < 2; f++)
      CHECK(a.offset(f).y == b.offset(f).y && a.raised(f) == b.raised(f));
  }
}

}  // namespace

int main() {
  a_foot_keeps_its_place_while_the_body_is_moved();
  who_is_moved_aside_steps_with_one_foot_at_a_time_and_slides_not_at_all();
  a_foot_steps_only_where_there_is_ground_and_then_shorter();
  a_foot_is_not_lifted_while_the_other_does_not_stand();
  a_foot_that_hangs_behind_steps_unless_something_keeps_it();
  who_waits_leaves_a_foot_that_was_stopped_where_it_is();
  a_body_slows_down_where_its_feet_cannot_follow();
  what_a_motion_lifts_comes_back_to_its_place();
  who_waits_stands_where_its_step_has_ended();
  a_shorter_step_ends_where_there_is_ground_at_any_frame_rate();
  saved_and_loaded_it_goes_on();
  return check::report("footwork");
}
