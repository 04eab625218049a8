// Closed forms of a Winkler foundation, energy, guarantee and state, with free objects on layers.
#include <algorithm>

#include "check.h"
#include "soft/soft_scene.h"

namespace {

using namespace soft_scene;

constexpr double k = 2e5, area = 0.16;  // [Pa/m], [m^2] of the box's foot

Thing crate(double mass, double height) {
  Thing b = box({0.4, 0.4, 0.2}, mass, 10);
  b.position = {0, 0, 0.1 + height};
  return b;
}

void run(hp::Stepper& s, int frames) {
  for (int i = 0; i < frames; i++) frame(s);
}

// d = m g/(k A); what the layer exerts is the weight, to rounding, and the touch says the same.
void a_block_sinks_by_its_weight() {
  Layer layer;
  layer.damping = 4000;
  hp::Stepper s;
  build(s, {crate(10, 0)}, layer);
  run(s, 240);
  CHECK_NEAR(0.1 - s.qpos()[2], 10 * gravity / (k * area), 1e-9);
  CHECK_NEAR(upward(s), 10 * gravity, 1e-6);
  CHECK(s.result().touches.size() == 1);
  CHECK_NEAR(60 * s.result().touches[0].impulse.z, 10 * gravity, 1e-6);
  CHECK_NEAR(s.qvel()[2], 0, 1e-9);
  CHECK(s.result().soft.size() == 100 && s.result().diagnostics.lost_time == 0);
}

// T = 2 pi sqrt(m/(k A)) within 1 %, and after 90 bounces the height is the same within 1 %.
void it_bounces_with_its_period_and_keeps_its_energy() {
  const double rest = 10 * gravity / (k * area);
  hp::Stepper s;
  build(s, {crate(10, -1.9 * rest)}, {});
  std::vector<double> crossings;
  double last = 0, first_height = 0, last_height = 0;
  for (int i = 0; i < 600; i++) {
    frame(s);
    const double z = s.qpos()[2] - (0.1 - rest);
    if (last < 0 && z >= 0) crossings.push_back(i - z / (z - last));
    if (i < 30) first_height = std::max(first_height, z);
    if (i >= 570) last_height = std::max(last_height, z);
    last = z;
  }
  const double period = (crossings.back() - crossings.front()) / (crossings.size() - 1.0) / 60;
  CHECK_NEAR(period, 2 * M_PI * std::sqrt(10 / (k * area)), 0.01 * period);
  CHECK_NEAR(last_height, first_height, 0.01 * first_height);
}

// The logarithmic decrement of a damping ratio of 0.05, within 1 %.
void its_bounce_is_damped_by_the_layer() {
  const double ratio = 0.05, m = 10, rest = m * gravity / (k * area);
  Layer layer;
  layer.damping = 2 * ratio * std::sqrt(k * area * m) / area;
  hp::Stepper s;
  build(s, {crate(m, -1.5 * rest)}, layer);
  std::vector<double> z, peaks;
  for (int i = 0; i < 70; i++) {
    frame(s, 1.0 / 240, 1);
    z.push_back(s.qpos()[2] - (0.1 - rest));
    const size_t n = z.size();
    if (n < 4 || !(z[n - 2] > z[n - 3] && z[n - 2] >= z[n - 1])) continue;
    const double bend = 0.5 * (z[n - 3] - 2 * z[n - 2] + z[n - 1]),
                 tilt = 0.5 * (z[n - 1] - z[n - 3]);
    peaks.push_back(z[n - 2] - tilt * tilt / (4 * bend));
  }
  const double expected = 2 * M_PI * ratio / std::sqrt(1 - ratio * ratio);
  CHECK_NEAR(std::log(peaks[0] / peaks[1]), expected, 0.012 * expected);
}

// F = pi k R d^2 (1 - d/(3 R)): the second term is exact for a sphere.
void a_ball_presses_a_bowl() {
  Layer layer;
  layer.damping = 2000;
  Thing b = ball(0.11, 2, 4000);
  b.position = {0, 0, 0.11};
  hp::Stepper s;
  build(s, {b}, layer);
  run(s, 400);
  const double d = 0.11 - s.qpos()[2];
  CHECK_NEAR(M_PI * k * 0.11 * d * d * (1 - d / 0.33), 2 * gravity, 0.005 * 2 * gravity);
  CHECK_NEAR(upward(s), 2 * gravity, 1e-3 * 2 * gravity);
  double highest = 0;
  for (const hp::SoftPoint& p : s.result().soft) highest = std::max(highest, p.pressure);
  CHECK_NEAR(highest, k * d, 0.01 * k * d);  // of the profile k (d - r^2/(2 R)), in its middle
}

// F = 4/3 k L sqrt(2 R) d^1.5, for depths much smaller than the radius.
void a_cylinder_presses_a_trough() {
  Layer layer;
  layer.damping = 2000;
  Thing b = roll(0.1, 0.3, 1, 720, 10);
  b.position = {0, 0, 0.1};
  hp::Stepper s;
  build(s, {b}, layer);
  run(s, 400);
  const double d = 0.1 - s.qpos()[2];
  CHECK_NEAR(4 / 3.0 * k * 0.3 * std::sqrt(0.2) * std::pow(d, 1.5), gravity, 0.01 * gravity);
}

// M/(k I_A), M about the middle of the foot as it stands: the centre of mass leans over, too.
void a_load_beside_the_middle_tilts() {
  Layer layer;
  layer.damping = 4000;
  Thing b = box({0.4, 0.4, 0.2}, 10, 20);
  b.position = {0, 0, 0.1};
  hp::Stepper s;
  build(s, {b}, layer);
  s.system.model.ipos[1] = {0.02, 0, 0};
  run(s, 300);
  const double tilt = 2 * std::asin(s.qpos()[5]), moment = 10 * gravity * (0.02 + 0.1 * tilt);
  CHECK_NEAR(tilt, moment / (k * std::pow(0.4, 4) / 12), 0.01 * tilt);
}

// 100 and 10,000 times as stiff: nearer and nearer to where a hard surface would hold it, up to the
// 0.01 mm over which a sample is spread at least.
void stiff_layers_come_to_hard_ones() {
  for (const double stiffer : {100.0, 1e4}) {
    Layer layer;
    layer.stiffness = stiffer * k, layer.damping = 100 * std::sqrt(stiffer) * 100;
    hp::Stepper s;
    build(s, {crate(10, 0)}, layer);
    run(s, 90);
    CHECK_NEAR(0.1 - s.qpos()[2], 10 * gravity / (stiffer * k * area), 1e-5);
    CHECK(std::fabs(s.qvel()[2]) < 1e-6);
  }
}

// What a layer cannot carry ends on its frame, by the clearance; the layer carries its share.
void too_much_ends_on_the_frame() {
  Layer layer;
  layer.thickness = 0.05;
  hp::Stepper s;
  build(s, {crate(2000, 0)}, layer);
  run(s, 120);
  CHECK_NEAR(s.qpos()[2], 0.1 - 0.05 + 1e-3, 1e-5);
  CHECK_NEAR(upward(s), k * area * 0.049, 1);
}

// At 30 m/s, with steps of 1/60 s: the frame beneath is never entered.
void speed_does_not_pass_the_frame() {
  for (const double speed : {5.0, 30.0}) {
    Thing b = ball(0.05, 1, 600);
    b.position = {0, 0, 0.6}, b.velocity = {1, 0.3, -speed};
    hp::Stepper s;
    build(s, {b}, {});
    double lowest = 1;
    for (int i = 0; i < 60; i++) {
      frame(s, 1.0 / 30, 2);
      lowest = std::min(lowest, s.qpos()[2]);
    }
    CHECK(lowest >= -0.1 + 0.05);
    CHECK(s.result().breaches.empty());
  }
}

// Without damping a ball comes back to where it fell from, and never higher.
void a_drop_gains_nothing() {
  Layer layer;
  layer.thickness = 0.2;
  Thing b = ball(0.11, 0.5, 2000);
  b.position = {0, 0, 0.11 + 0.3};
  hp::Stepper s;
  build(s, {b}, layer);
  double heights[4] = {0, 0, 0, 0}, last = 0;
  int n = 0;
  for (int i = 0; i < 1500 && n < 4; i++) {
    frame(s, 1.0 / 240, 1);
    if (last > 0 && s.qvel()[2] <= 0) heights[n++] = s.qpos()[2] - 0.11;
    last = s.qvel()[2];
  }
  CHECK(n == 4);
  for (int i = 0; i < n; i++) CHECK(heights[i] < 0.3001 && heights[i] > 0.3 * (1 - 0.01 * (i + 1)));
}

// By pressure: v^2/(2 mu g), less or more by half a step's way and how far the foot leans.
void friction_is_of_the_pressure() {
  Layer layer;
  layer.damping = 4000, layer.friction = 0.5;
  Thing b = crate(10, -10 * gravity / (k * area));
  b.velocity = {1, 0, 0};
  hp::Stepper s;
  build(s, {b}, layer);
  run(s, 60);
  CHECK_NEAR(s.qpos()[0], 1 / (2 * 0.5 * gravity), 0.006);
  CHECK_NEAR(s.qvel()[0], 0, 1e-6);
}

// A hard box on a soft one on a hard floor: each surface carries what is above it.
void a_pillow_gives_on_both_sides() {
  Layer hard;
  hard.thickness = 0, hard.stiffness = 0;
  Thing pillow = box({0.4, 0.4, 0.16}, 2, 10), b = box({0.3, 0.3, 0.2}, 10, 10);
  pillow.thickness = 0.02, pillow.stiffness = 1e5, pillow.damping = 3000;
  pillow.position = {0, 0, 0.1}, b.position = {0, 0, 0.3};
  hp::Stepper s;
  build(s, {pillow, b}, hard);
  run(s, 300);
  CHECK_NEAR(s.qpos()[2], 0.1 - 12 * gravity / (1e5 * area), 1e-5);
  CHECK_NEAR(s.qpos()[9] - s.qpos()[2], 0.2 - 10 * gravity / (1e5 * 0.09), 1e-5);
}

// Foam gives back less than it took, and its surface comes back slowly.
void foam_remembers() {
  Layer layer;
  layer.arm = 1, layer.relaxation = 0.05;
  hp::Stepper s, linear;
  build(s, {crate(20, 0.1)}, layer);
  build(linear, {crate(20, 0.1)}, {});
  double top = 0, linear_top = 0;
  for (int i = 0; i < 60; i++) {
    frame(s), frame(linear);
    if (i > 25) top = std::max(top, s.qpos()[2]);
    if (i > 25) linear_top = std::max(linear_top, linear.qpos()[2]);
  }
  CHECK(top - 0.1 < 0.7 * (linear_top - 0.1));
  // At rest the arm has slackened: the springs carry all.
  run(s, 600);
  CHECK_NEAR(0.1 - s.qpos()[2], 20 * gravity / (k * area), 1e-5);
}

// From a snapshot on, the same bits: levels, friction and what foam remembers are in it.
void a_snapshot_goes_on_as_before() {
  Layer layer;
  layer.damping = 500, layer.densification = 5, layer.arm = 0.4, layer.relaxation = 0.3;
  Thing b = ball(0.11, 2, 500), c = crate(3, 0.02);
  b.position = {0, 0, 0.2}, b.velocity = {1, 0, 0}, c.position.x = 0.5;
  hp::Stepper s;
  build(s, {b, c}, layer);
  run(s, 20);
  const std::vector<double> state = s.save();
  run(s, 20);
  const std::vector<double> there = s.qpos();
  s.load(state);
  run(s, 20);
  CHECK(s.qpos() == there);
}

// Who sleeps on a layer stays until something comes, and presses then.
void a_sleeper_wakes_when_something_presses_it() {
  Layer layer;
  layer.damping = 4000;
  Thing pillow = crate(10, 0), b = ball(0.05, 1, 300);
  pillow.thickness = 0.02, pillow.stiffness = 1e5;
  pillow.position.z += 0.02;
  b.position = {0, 0, 0.6};
  hp::Stepper s;
  build(s, {pillow, b}, layer);
  s.start_asleep(1);
  const std::vector<double> start = s.qpos(), still(12, 0.0);
  s.reset(start.data(), still.data());
  run(s, 6);
  CHECK(s.qpos()[2] == start[2]);
  run(s, 60);
  CHECK(s.qpos()[2] < start[2] - 1e-3);
}

}  // namespace

int main() {
  a_block_sinks_by_its_weight();
  it_bounces_with_its_period_and_keeps_its_energy();
  its_bounce_is_damped_by_the_layer();
  a_ball_presses_a_bowl();
  a_cylinder_presses_a_trough();
  a_load_beside_the_middle_tilts();
  stiff_layers_come_to_hard_ones();
  too_much_ends_on_the_frame();
  speed_does_not_pass_the_frame();
  a_drop_gains_nothing();
  friction_is_of_the_pressure();
  a_pillow_gives_on_both_sides();
  foam_remembers();
  a_snapshot_goes_on_as_before();
  a_sleeper_wakes_when_something_presses_it();
  return check::report("soft_contacts");
}
