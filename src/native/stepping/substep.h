// The substep: one step of length h, verified (docs/physics.md, "The substep").
//
//   free velocity (1)     v*: drive, forces of joints, gravity; limits of strength, held loads, the
//                         weight of who stands on things (standing_load.h)
//   attempt (2 to 7)      broad phase, candidates, contacts, solve, verify (contact_step.h); made
//                         again where bodies wake or come out of an overlap too fast
//                         (step_attempts.h), where a kinematic body squeezes others, or where a
//                         joint exceeds its strength
//   commit or shorten (8) the whole step, or a share of it and the rest in pieces (sub_stepping.h)
//   end                   velocities at the end, what the drives exerted, clocks of trajectories
//
// `run` reads like that; the numbers are those of docs/physics.md.
#pragma once
#include "stepping/free_motion.h"
#include "stepping/squeezed.h"
#include "stepping/standing_load.h"
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
        sub_stepping_(system, data, kinematic, attempts_, strength_) {}
  void finish();
  // Substep k of the frame, of length h [s], of active trees.
  void run(int k, double h);
  // Nothing is made of such a time [s]: it is lost.
  void lose(double h);
  // Into how many parts a substep of length h is to be cut because of objects and links that turn
  // far: a contact is a straight line where they go in a circle, and would add energy.
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
  StandingLoad standing_;
  StrengthLimits strength_{load_, internal_};
  SqueezeLimit squeezed_;
  StepAttempts attempts_;
  SubStepping sub_stepping_;
};

}  // namespace hp
