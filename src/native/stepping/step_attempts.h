// Attempts at a step: the contact step, tried again until nothing in it is to change.
//
//   repeat                     while the attempt wakes sleeping objects (sleeping.h)
//     repeat                   while objects leave prescribed people too fast (baselines)
//       repeat                 while bodies come out of an initial overlap too fast (exit_motion.h)
//         contact step         (contact_step.h)
#pragma once
#include "stepping/baselines/prescribed_poses.h"
#include "stepping/contact_step.h"
#include "stepping/exit_motion.h"

namespace hp {

class StepAttempts {
 public:
  StepAttempts(System& system, Data& data, const KinematicBodies& kinematic,
               PrescribedPoses& prescribed)
      : system_(system),
        data_(data),
        prescribed_(prescribed),
        contact_step_(system, data, kinematic) {}
  // A step of length h [s] from the present pose; the answer is in data.step and data.attempt.
  void run(double h);

 private:
  void run_prescribed(double h);
  void run_exits(double h);

  System& system_;
  Data& data_;
  PrescribedPoses& prescribed_;
  ContactStep contact_step_;
  ExitMotion exit_;
};

}  // namespace hp
