// What is recorded of a run of frames, for Python.
#pragma once
#include "bindings/stepper.h"

namespace hp {

struct Recording {
  std::vector<double> torques, torque_frames, poses, clearance, lost, touches, touch_count, numbers,
      inside, inside_count, soft, soft_count, breaches, breach_count, footing;
  size_t done = 0;  // frames

  void add(Stepper& s);
  nb::dict dict(const Stepper& s) const;
};

// Frames to run: targets of all people (frames, numbers of targets), and lambda of all balls in
// every frame (frames, balls), or null to leave it. Coordinates of every frame go to `qpos`
// (frames, nq).
struct Frames {
  const double* targets = nullptr;
  const double* stiffness = nullptr;
  double* qpos = nullptr;
  size_t count = 0;
  double dt = 0;
  int substeps = 1;
  bool record = false;  // the poses after every substep too

  // Throws std::invalid_argument where the arrays do not fit the stepper.
  static Frames of(const Stepper& s, const Square& targets, double dt, int substeps, bool record,
                   const Square& stiffness, const Out& qpos);
  // Runs the next frame and records it.
  void run(Stepper& s, Recording& recording) const;
};

}  // namespace hp
