// Aiming: where people are driven in a frame, given what is asked of them (docs/physics.md, "Weight").
//
//   asked pose  ->  clock: who is blocked waits       (reference_clock.h)
//               ->  footing: who stands, stands on it (../footing/footing.h)
//               ->  drive: velocities                 (drive.h)
//
// and how much force moves them as a whole: that of the ground, by which they stand.
#pragma once
#include "stepping/data.h"

namespace hp {

class Aiming {
 public:
  // After a reset, that of the collision world too: who begins near the ground begins on it, unless
  // it would thereby be deeper in anything than the motion has it.
  void start(System& system, State& state);
  // A frame of length dt [s] towards the people's `targets` begins; its results are cleared.
  void begin(System& system, Data& data, const double* targets, double dt);
  // The frame has been made: who is held up by contacts.
  static void end(System& system, const FrameResult& result);

 private:
  // Per person: how deep it starts in a thing [m].
  struct Depth {
    int person, other_static, other_tree;
    double depth;
  };
  static std::vector<Depth> depths(const System& system);
  static bool deeper(const std::vector<Depth>& before, const std::vector<Depth>& after, int person);
  bool stand(System& system, State& state);
  void place_feet(System& system, State& state, Drive& d, const double* asked, double dt);
  static void restart_world(System& system, State& state);

  std::vector<double> target_;
};

}  // namespace hp
