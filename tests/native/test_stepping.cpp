// Components of a step alone: trajectories, efforts, gentle returns, touches and islands.
#include <cmath>

#include "check.h"
#include "small_person.h"

namespace {

using hp::Quat;
using hp::Vec3;

hp::Trajectory there_and_back(bool loop) {
  hp::Trajectory t;
  t.fps = 2;
  t.loop = loop;
  t.position = {{0, 0, 0}, {1, 0, 0}, {1, 2, 0}};
  t.turn.assign(3, Quat{1, 0, 0, 0});
  t.turn[1] = hp::exp_quat({0, 0, 0.4});
  return t;
}

// Straight lines and constant rates between poses; the last pose holds, or the first follows it.
void a_trajectory_goes_from_pose_to_pose() {
  Vec3 p;
  Quat q;
  there_and_back(false).at(0.125, p, q);
  CHECK_NEAR(p.x, 0.25, 1e-15);
  CHECK_NEAR(2 * std::atan2(q.z, q.w), 0.1, 1e-15);
  there_and_back(false).at(100, p, q);
  CHECK(p.x == 1 && p.y == 2);
  there_and_back(true).at(1.25, p, q);  // half way from the last pose to the first
  CHECK_NEAR(p.x, 0.5, 1e-15);
  CHECK_NEAR(p.y, 1, 1e-15);
  there_and_back(true).at(1.5, p, q);
  CHECK(p.x == 0 && p.y == 0);
  // A time within rounding of a pose gives that pose.
  there_and_back(false).at(0.5 + 1e-12, p, q);
  CHECK(p.x == 1 && p.y == 0);
}

void an_effort_is_the_mean_over_its_frame() {
  hp::DriveEffort effort(2);
  CHECK(!effort.any() && effort.mean_force(0.1).empty());
  const double first[] = {1, 0}, second[] = {2, -1};
  effort.add(first);
  effort.add(second);
  const std::vector<double> force = effort.mean_force(0.1);
  CHECK_NEAR(force[0], 30, 1e-13);
  CHECK_NEAR(force[1], -10, 1e-13);
  effort.begin_frame();
  CHECK(!effort.any());
  effort.add(second);  // the previous content is gone
  CHECK_NEAR(effort.mean_force(1)[0], 2, 0);
}

void a_gentle_return_ends_at_the_motion_or_after_its_time() {
  hp::Stepper s;
  small_person::build(s, 0.02);
  const hp::Drive& d = s.system.drives[0];
  const std::vector<double> pose = small_person::pose(0, 1);
  std::vector<double> bent = pose;
  hp::store4(&bent[d.balls()[1].qpos],
             hp::exp_quat({0.5, 0, 0}) * hp::load4(&pose[d.balls()[1].qpos]));
  hp::GentleReturn back;
  CHECK(!back.active());
  back.start(d, 0.7, s.system.joint_reach);
  CHECK(back.active());
  for (int i = 0; i < d.ball_count(); i++) CHECK(back.rate(i) > 0 && back.rate(i) <= 0.7 / 0.02);
  back.end_frame(d, true, 10, pose.data(), pose.data());  // still inside: the timer stands still
  CHECK(back.active());
  back.end_frame(d, false, 0.1, pose.data(), bent.data());  // outside, not back yet
  CHECK(back.active());
  back.end_frame(d, false, 0.1, pose.data(), pose.data());  // back at the motion
  CHECK(!back.active());
  back.start(d, 0.7, s.system.joint_reach);
  back.end_frame(d, false, 10, pose.data(), bent.data());  // its time is over
  CHECK(!back.active());
}

// One touch for contacts of a pair with about the same normal, another where normals differ.
void touches_of_a_pair_are_summed_by_their_normals() {
  hp::FrameResult result;
  result.clear(3);
  hp::ContactCandidate pair;
  pair.shape = 0, pair.other_static = 1;
  hp::Contact c;
  c.n = {0, 0, 1}, c.impulse = {0, 0, 2}, c.position = {1, 0, 0};
  result.add(pair, c);
  c.impulse = {1, 0, 2}, c.position = {3, 0, 0};
  result.add(pair, c);
  CHECK(result.touches.size() == 1);
  const hp::Touch& t = result.touches[0];
  CHECK_NEAR(t.impulse.x, 1, 0);
  CHECK_NEAR(t.impulse.z, 4, 0);
  CHECK_NEAR(t.weight, 4, 0);
  CHECK_NEAR(t.position.x / t.weight, 2, 0);
  c.n = {1, 0, 0}, c.impulse = {1, 0, 0};
  result.add(pair, c);
  CHECK(result.touches.size() == 2);
  pair.other_static = 2;
  result.add(pair, c);
  CHECK(result.touches.size() == 3);
}

// Candidates connect active trees only.
void islands_are_what_candidates_connect() {
  hp::System system;
  const int nbody = 5;
  system.model.nbody = nbody;
  for (int b = 0; b < nbody; b++) system.model.root.push_back(b);
  system.world.shapes.resize(4);
  for (int i = 0; i < 4; i++) system.world.shapes[i].body = i + 1;
  system.world.active.assign(nbody, 1);
  system.world.active[3] = 0;
  auto between = [](int a, int b) {
    hp::ContactCandidate c;
    c.shape = a, c.other_shape = b;
    return c;
  };
  const std::vector<hp::ContactCandidate> candidates = {between(0, 1), between(1, 2),
                                                        between(2, 3)};
  hp::Islands islands;
  islands.find(system, candidates);
  CHECK(islands.of_tree(1) == islands.of_tree(2));
  CHECK(islands.of_tree(3) == 3);  // it is static
  CHECK(islands.of_tree(4) == 4);
  CHECK(islands.of(system, candidates[1]) == islands.of_tree(2));  // the island of its active side
  CHECK(islands.of(system, candidates[2]) == islands.of_tree(4));
}

}  // namespace

int main() {
  a_trajectory_goes_from_pose_to_pose();
  an_effort_is_the_mean_over_its_frame();
  a_gentle_return_ends_at_the_motion_or_after_its_time();
  touches_of_a_pair_are_summed_by_their_normals();
  islands_are_what_candidates_connect();
  return check::report("test_stepping");
}
