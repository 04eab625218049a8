// A person stepped without Python: exact tracking without contact, and no penetration.
#include "check.h"
#include "small_person.h"

namespace {

constexpr double dt = 1.0 / 30;
constexpr int frames = 45, substeps = 8;

// Without contact, the pose at the end of a frame is the motion's own.
void follows(double time_constant) {
  hp::Stepper s;
  small_person::build(s, time_constant);
  const double height = 2;
  std::vector<double> start = small_person::pose(0, height), rest(s.system.model.nv, 0.0);
  s.reset(start.data(), rest.data());
  for (int k = 1; k <= frames; k++) {
    const std::vector<double> target = small_person::pose(k * dt, height);
    s.frame(target.data(), dt, substeps);
    for (int i = 0; i < small_person::numbers; i++)
      CHECK_NEAR(s.qpos()[i], target[i], 1e-12);  // rounding of 45 frames
    CHECK(s.result().touches.empty());
  }
}

// The same with every substep computed, as if a contact were possible.
void follows_step_by_step(double time_constant) {
  hp::Stepper s;
  small_person::build(s, time_constant);
  s.probe.keep_pieces = true;
  const double height = 2;
  std::vector<double> start = small_person::pose(0, height), rest(s.system.model.nv, 0.0), poses;
  s.reset(start.data(), rest.data());
  for (int k = 1; k <= frames; k++) {
    const std::vector<double> target = small_person::pose(k * dt, height);
    s.frame(target.data(), dt, substeps, &poses);
    for (int i = 0; i < small_person::numbers; i++) CHECK_NEAR(s.qpos()[i], target[i], 1e-12);
  }
  CHECK((int)poses.size() == frames * substeps * small_person::numbers);
}

// The motion sinks half a metre into the floor: the body stays above it at every substep's pose.
void stays_above_the_floor(double time_constant) {
  hp::Stepper s;
  small_person::build(s, time_constant);
  const double height = 1.1;  // legs are 0.92 m long including their capsule
  std::vector<double> start = small_person::pose(0, height), rest(s.system.model.nv, 0.0), poses;
  CHECK(small_person::lowest(start.data()) > 0.1);
  s.reset(start.data(), rest.data());
  double impulse = 0, lost = 0;
  for (int k = 1; k <= frames; k++) {
    const double t = k * dt;
    const std::vector<double> target = small_person::pose(t, height - 0.5 * t);
    s.frame(target.data(), dt, substeps, &poses);
    for (const hp::Touch& touch : s.result().touches) impulse += touch.impulse.z;
    lost += s.result().diagnostics.lost_time;
  }
  const std::vector<double> last = small_person::pose(frames * dt, height - 0.5 * frames * dt);
  CHECK(small_person::lowest(last.data()) < -0.4);
  double least = 1;
  for (size_t i = 0; i < poses.size(); i += small_person::numbers)
    least = std::min(least, small_person::lowest(&poses[i]));
  // The clearance of 1 mm, less the tolerance of a gap (2 %).
  CHECK(least > 0.97e-3);
  CHECK(least < 1.1e-3);
  CHECK_NEAR(s.clearance(), small_person::lowest(s.qpos().data()), 1e-9);
  CHECK(impulse > 0);
  CHECK_NEAR(lost, 0, 0);
}

// A restored state continues as the uninterrupted run does.
void goes_on_from_a_state() {
  hp::Stepper a, b;
  small_person::build(a, 0.02);
  small_person::build(b, 0.02);
  std::vector<double> start = small_person::pose(0, 1.0), rest(a.system.model.nv, 0.0);
  a.reset(start.data(), rest.data());
  b.reset(start.data(), rest.data());
  for (int k = 1; k <= frames; k++) {
    const std::vector<double> target = small_person::pose(k * dt, 1.0 - 0.3 * k * dt);
    a.frame(target.data(), dt, substeps);
    if (k == 20) b.load(a.save());
    if (k > 20) b.frame(target.data(), dt, substeps);
  }
  CHECK(a.qpos() == b.qpos());
}

}  // namespace

int main() {
  for (double time_constant : {0.0, 0.02}) {
    follows(time_constant);
    follows_step_by_step(time_constant);
    stays_above_the_floor(time_constant);
  }
  goes_on_from_a_state();
  return check::report("test_person");
}
