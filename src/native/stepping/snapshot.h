// Snapshots: everything that outlives a frame, as a flat list of numbers, to go on from there
// later.
//
// Layout: the numbers that say of what it is, qpos, qvel, drives, world, exit paths, sleeping bodies,
// kinematic bodies, pushes of prescribed people (where there are any), contact cache, and the number of
// entries before the last one.
#pragma once
#include "stepping/baselines/prescribed_poses.h"
#include "stepping/kinematic_bodies.h"

namespace hp {

// The parts of a simulation that a snapshot is of.
struct Snapshot {
  System& system;
  Data& data;
  KinematicBodies& kinematic;
  PrescribedPoses& prescribed;

  std::vector<double> save();
  // Throws std::invalid_argument if the state has been cut off, or is of a simulation of other parts.
  void check(const std::vector<double>& state) const;
  void load(const std::vector<double>& state);
  // After a reset at the poses of `old`: goes on as that would. `body` and `shape`: the number of
  // each here in `old`, -1: it is new. Throws std::invalid_argument unless people are the same.
  void adopt(const Snapshot& old, const std::vector<int>& body, const std::vector<int>& shape);

 private:
  // What a state's length depends on, but for what it says itself.
  std::vector<double> parts() const;
  void adopt_bodies(const Snapshot& old, const std::vector<int>& body);
  void adopt_drives(const Snapshot& old);
};

// Velocities of people who followed their path without substeps are those of the motion: brings
// qvel up to date.
void update_velocity(const System& system, State& state);

}  // namespace hp
