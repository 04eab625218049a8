// Angles of ball joints and their rates.
#include "dynamics/joint_range.h"

#include <algorithm>
#include <cmath>
#include <cstdint>
#include <stdexcept>

#include "check.h"

namespace {

constexpr double kStep = 1e-5, kTolerance = 1e-8, kRounding = 1e-12;

// A number in [-1, 1) that depends on `seed` alone.
double drawn(uint64_t& seed) {
  seed = seed * 6364136223846793005ull + 1442695040888963407ull;
  return (double)(int64_t)seed / 9.3e18;
}

hp::JointRange range() {
  hp::JointRange r;
  const hp::Vec3 t = (1.0 / 3) * hp::Vec3{1, 2, 2};
  hp::tangents(t, r.axis[1], r.axis[2]);
  r.axis[0] = t;
  for (int i = 0; i < 3; i++) r.lower[i] = -0.4 - 0.1 * i, r.upper[i] = 0.9 + 0.3 * i;
  r.finish();
  return r;
}

void rates_are_those_of_the_angles() {
  const hp::JointRange r = range();
  uint64_t seed = 3;
  for (int trial = 0; trial < 200; trial++) {
    const double size = trial < 20 ? 1e-6 : 1.4;
    const hp::Quat q = hp::exp_quat(size * hp::Vec3{drawn(seed), drawn(seed), drawn(seed)});
    hp::Vec3 rates[3];
    hp::joint_angle_rates(r, q, rates);
    for (int k = 0; k < 3; k++) {
      hp::Vec3 e;
      e[k] = kStep;
      const hp::Vec3 change =
          hp::joint_angles(r, q * hp::exp_quat(e)) - hp::joint_angles(r, q * hp::exp_quat(-e));
      for (int i = 0; i < 3; i++) CHECK_NEAR(rates[i][k], change[i] / (2 * kStep), kTolerance);
    }
  }
}

void what_holds_is_within_all_ends() {
  const hp::JointRange r = range();
  uint64_t seed = 5;
  int held = 0;
  for (int trial = 0; trial < 2000; trial++) {
    hp::Quat q = hp::exp_quat(2.0 * hp::Vec3{drawn(seed), drawn(seed), drawn(seed)});
    if (trial % 2) q = {-q.w, -q.x, -q.y, -q.z};
    const hp::Vec3 a = hp::joint_angles(r, q);
    bool within = true;
    for (int i = 0; i < 3; i++) within &= a[i] >= r.lower[i] && a[i] <= r.upper[i];
    CHECK(r.holds(q) == within);
    held += within;
  }
  CHECK(held > 100 && held < 1800);
}

void angles_and_rotations_are_the_same_thing() {
  const hp::JointRange r = range();
  uint64_t seed = 7;
  for (int trial = 0; trial < 1000; trial++) {
    const hp::Vec3 a = 1.5 * hp::Vec3{drawn(seed), drawn(seed), drawn(seed)};
    const hp::Vec3 again = hp::joint_angles(r, hp::from_joint_angles(r, a));
    for (int i = 0; i < 3; i++) CHECK_NEAR(again[i], a[i], kRounding);
  }
}

void clamping_goes_no_farther_than_the_range_or_what_is_asked() {
  const hp::JointRange r = range();
  uint64_t seed = 11;
  int beyond = 0;
  for (int trial = 0; trial < 1000; trial++) {
    const hp::Quat q = hp::exp_quat(2.0 * hp::Vec3{drawn(seed), drawn(seed), drawn(seed)});
    const hp::Quat asked = hp::exp_quat(1.4 * hp::Vec3{drawn(seed), drawn(seed), drawn(seed)});
    const hp::Vec3 own = hp::joint_angles(r, q), wish = hp::joint_angles(r, asked),
                   kept = hp::clamped_angles(r, q, asked);
    for (int i = 0; i < 3; i++) {
      const double low = std::min(r.lower[i], wish[i]), up = std::max(r.upper[i], wish[i]);
      CHECK_NEAR(kept[i], std::clamp(own[i], low, up), kRounding);
      beyond += kept[i] != own[i];
    }
  }
  CHECK(beyond > 300);
}

bool refused(hp::JointRange r) {
  try {
    r.finish();
  } catch (const std::invalid_argument&) {
    return true;
  }
  return false;
}

void bad_axes_are_refused() {
  hp::JointRange mirrored = range(), none = range();
  mirrored.axis[1] = -mirrored.axis[1];
  none.axis[1].x = std::nan("");
  CHECK(!refused(range()));
  CHECK(refused(mirrored));
  CHECK(refused(none));
}

}  // namespace

int main() {
  rates_are_those_of_the_angles();
  what_holds_is_within_all_ends();
  angles_and_rotations_are_the_same_thing();
  clamping_goes_no_farther_than_the_range_or_what_is_asked();
  bad_axes_are_refused();
  return check::report("joint_range");
}
