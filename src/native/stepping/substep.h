// The substep: one step of length h, verified (docs/physics.md, "The substep").
//
//   1. free velocity    v*: drive, forces of joints, gravity; limits of strength, held loads
//   2. attempts         planes, contacts, solve, verify (contact_step.h), tried again where bodies wake,
//                       come out of an overlap too fast (step_attempts.h), squeeze others or are too weak
//   3. commit, or shorten and go on in pieces (sub_stepping.h)
//   4. end              velocities at the end, what the drives exerted, clocks of trajectories
//
// `run` reads like that.
#pragma once
#include "stepping/free_motion.h"
#include "stepping/strength.h"
#include "stepping/sub_stepping.h"

namespace hp {

class Substep {
 public:
  Substep(System& system, Data& data, KinematicBodies& kinematic, PrescribedPoses& prescribed)
      : system_(system),
        data_(data),
        kinematic_(kinematic),
        attempts_(system, data, kinematic, prescribed),
        sub_stepping_(system, data, kinematic, attempts_) {}
  void finish();
  // Substep k of the frame, of length h [s], of active trees.
  void run(int k, double h);
  // Into how many parts a substep of length h is to be cut because of objects and links that turn far: a
  // contact is a straight line where they go in a circle, and would add energy.
  int parts(double h) const;

 private:
  void begin(double h);
  void free_velocity(int k, double h);
  bool again(double h);
  void trace(int k, double h);
  void end(double h, double lost);

  System& system_;
  Data& data_;
  KinematicBodies& kinematic_;
  FreeMotion free_;
  InternalForces internal_;
  HeldLoad load_;
  StrengthLimits strength_;
  StepAttempts attempts_;
  SubStepping sub_stepping_;
};

}  // namespace hp
