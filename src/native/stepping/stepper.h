// The stepper: a simulation of people, objects and articulations, frame by frame.
//
// A frame of the motion, of length dt, is made of n substeps (substep.h) of h = dt/n; people who
// meet nothing on their way need none (free_paths.h). docs/physics.md has the physics,
// docs/design.md the components.
//
//   Stepper            frames, resets, snapshots
//     System           trees, shapes, drives, settings          (system.h)
//     Data             state, step, attempt, results            (data.h)
//     Aiming           where people are driven in a frame
//     FreePaths        people who need no substeps
//     KinematicBodies  objects on trajectories
//     PrescribedPoses  baseline: people whose poses are set
//     Hosting          another engine's world
//     Substep          free velocity, attempts, sub-stepping    (substep.h)
#pragma once
#include "stepping/free_paths.h"
#include "stepping/hosting.h"
#include "stepping/snapshot.h"

namespace hp {

class Stepper {
 public:
  System system;
  Probe& probe = data_.probe;

  Stepper() : substep_(system, data_, kinematic_, prescribed_) {}
  Stepper(const Stepper&) = delete;
  Stepper& operator=(const Stepper&) = delete;

  // A kinematic body; after the model is filled in.
  void add_trajectory(Trajectory t) { kinematic_.add(system.model, std::move(t)); }
  // An object that sleeps after a reset until something touches it.
  void start_asleep(int body);
  // After model and shapes are filled in. `person_roots`: the root body of every person.
  void finish(const std::vector<int>& person_roots);

  // The pose to start from; people must be at their targets and start at rest. Objects keep qvel. With
  // `stand` people who are to have weight stand on what is near under them; without, all are as they are.
  void reset(const double* qpos, const double* qvel, bool stand = true);
  // One frame of length dt [s] in n substeps. `targets`: the people's qpos, one after the other.
  // With `poses`, the pose after every substep is appended to it.
  void frame(const double* targets, double dt, int n, std::vector<double>* poses = nullptr);
  // Another engine's frame of n timesteps of length h [s] (hosting.h).
  void start_hosted(Host& host) { hosting_.start(system, data_, host); }
  void show_hosted(Host& host) { Hosting::show(system, data_, host); }
  std::vector<double> hosted_forces() const { return hosting_.forces().save(); }
  void set_hosted_forces(const std::vector<double>& rows) { hosting_.forces().load(rows); }
  void begin_hosted(Host& host, const double* targets, int n, double h, bool watched) {
    hosting_.begin(system, data_, aiming_, host, targets, n, h, watched);
  }
  void before_hosted(int k) { hosting_.before(system, data_, k); }
  void after_hosted(int k) { hosting_.after(system, data_, substep_, k); }
  void end_hosted() { hosting_.end(system, data_); }
  // The six velocities of an object, which wakes.
  void set_velocity(int body, const double* six);

  const std::vector<double>& qpos() const { return data_.state.qpos; }
  const std::vector<double>& qvel();
  const FrameResult& result() const { return data_.result; }
  // What the drives exert on all balls, mean over the last frame [N m] (3 ball_count()), in the
  // children's frames, appended to `out`; nothing, and false, if it is zero.
  bool torques(std::vector<double>& out) const;
  // Of every person: how far its reference is behind [s], and whether its target was corrected, 0 or 1
  // (footing.h); appended to `out`.
  void footing(std::vector<double>& out) const;
  // What the last frame cost, in budgets of a frame (step_budget.h).
  double frame_work() const { return data_.budget.spent(); }
  // Smallest distance of people from static geometry at the present pose, up to the range [m].
  double clearance();
  // Of any poses (poses x nq): distance and nearest static of every shape (poses x shapes), see
  // shape_clearances(). The simulation does not change.
  void clearances(const double* qpos, size_t poses, double range, double* dist, int* nearest) const;

  // Snapshots (snapshot.h).
  std::vector<double> save() { return snapshot().save(); }
  void load(const std::vector<double>& state);
  void adopt(Stepper& old, const std::vector<int>& body, const std::vector<int>& shape) {
    snapshot().adopt(old.snapshot(), body, shape);
  }

 private:
  Snapshot snapshot() { return {system, data_, kinematic_, prescribed_}; }
  void step_beside_free(double dt, int n, std::vector<double>* poses);
  bool hurries() const;
  int joined_substeps(int k, int n, double h) const;
  void substeps(double dt, int n, std::vector<double>* poses);

  Data data_;
  KinematicBodies kinematic_;
  PrescribedPoses prescribed_;
  Aiming aiming_;
  Hosting hosting_;
  FreePaths paths_;
  Substep substep_;
};

}  // namespace hp
