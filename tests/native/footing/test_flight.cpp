// Who flies, and who is carried.
#include "footing/flight.h"

#include <cmath>
#include <cstdint>

#include "check.h"

namespace {

constexpr double kGravity = 9.81;
constexpr double kFps[] = {30, 60, 120};

// A reference that has stood for a second, then goes on for another with root(t), lowest(t); how many of these
// frames fly, as a share. `rests`: something of it is still in that second.
template <class Root, class Lowest>
double flown(double fps, Root root, Lowest lowest, bool rests = false) {
  hp::Flight flight;
  for (int f = 0; f < (int)fps; f++) flight.see(root(0.0), lowest(0.0), true, 1 / fps, kGravity);
  int flies = 0;
  for (int f = 1; f <= (int)fps; f++) {
    flight.see(root(f / fps), lowest(f / fps), rests, 1 / fps, kGravity);
    flies += flight.flies();
  }
  return flies / fps;
}

double still(double) { return 0; }

void falling_is_flight() {
  for (double fps : kFps)
    CHECK(flown(fps, [](double t) { return -0.5 * kGravity * t * t; }, still) > 0.9);
}

void a_jump_flies_until_it_lands() {
  const double lasts = 0.4;
  const auto arc = [&](double t) { return t < lasts ? 0.5 * kGravity * t * (lasts - t) : 0.0; };
  for (double fps : kFps)
    // Feet that are pulled up with the body may be still on its way.
    for (bool rests : {false, true}) CHECK_NEAR(flown(fps, arc, arc, rests), lasts, 0.12);
}

void who_comes_down_on_a_foot_that_stands_does_not_fly() {
  // The trunk of a walk gains 0.6 g for a moment where the other foot lands.
  const auto comes_down = [](double t) { return t < 0.15 ? -0.3 * kGravity * t * t : -0.066; };
  for (double fps : kFps) {
    CHECK(flown(fps, comes_down, still, true) == 0);
    CHECK(flown(fps, comes_down, still, false) > 0);
  }
}

void who_bobs_or_trembles_does_not_fly() {
  uint64_t seed = 3;
  for (double fps : kFps) {
    CHECK(flown(fps, [](double t) { return 0.02 * std::sin(2 * M_PI * 2 * t); }, still) == 0);
    const auto trembles = [&](double) {
      seed = seed * 6364136223846793005ull + 1442695040888963407ull;
      return 0.001 * (double)(int64_t)seed / 9.3e18;
    };
    CHECK(flown(fps, trembles, still) < 0.05);
  }
}

void whose_lowest_point_leaves_the_ground_flies() {
  const auto up = [](double t) { return 1.0 * t; };
  for (double fps : kFps) CHECK(flown(fps, up, up) == 1);
}

void who_stands_still_in_time_stays_as_it_was() {
  hp::Flight flight;
  flight.see(1, 0, false, 0.02, kGravity);
  flight.see(0.9, 0, false, 0.02, kGravity);
  CHECK(flight.flies());
  flight.see(0.9, 0, false, 0, kGravity);
  CHECK(flight.flies());
}

void saved_and_loaded_it_goes_on() {
  hp::Flight a, b;
  for (int f = 0; f < 10; f++) a.see(1 - 0.01 * f * f, 0, false, 0.02, kGravity);
  std::vector<double> saved;
  a.save(saved);
  CHECK(b.load(saved.data()) == saved.data() + saved.size());
  for (int f = 10; f < 20; f++) {
    a.see(0.1 * std::cos(f), 0, f % 3 == 0, 0.02, kGravity);
    b.see(0.1 * std::cos(f), 0, f % 3 == 0, 0.02, kGravity);
    CHECK(a.flies() == b.flies() && a.lowest() == b.lowest());
  }
}

}  // namespace

int main() {
  falling_is_flight();
  a_jump_flies_until_it_lands();
  who_comes_down_on_a_foot_that_stands_does_not_fly();
  who_bobs_or_trembles_does_not_fly();
  whose_lowest_point_leaves_the_ground_flies();
  who_stands_still_in_time_stays_as_it_was();
  saved_and_loaded_it_goes_on();
  return check::report("flight");
}
