// Paths that curve within a substep: what velocities alone would let a hand lose of what it holds.
//
// A contact's friction row is linear in velocities, but a point of a rotating arm goes along an
// arc. With a the acceleration of one point past the other while all joints keep their velocities,
// a substep of length h takes the point by h v_t + h^2 curve_t along the surface, curve = a / 2
// [m/s^2]; friction asks that to be zero. Velocities are those of the substep before: what the
// drive asks of fingers that squeeze does not happen. docs/physics.md, "One hand, one glass", has
// what was measured.
//
// Only between a person and an object: of two objects, which no drive moves, neither has a path to
// keep to, and both would gain energy. Not with Algorithm 1 of the paper, nor for people whose
// poses are prescribed.
#pragma once
#include <vector>

#include "stepping/data.h"

namespace hp {

class PathCurvature {
 public:
  // An attempt begins: finds the velocities of bodies that state.qvel makes.
  void begin(const System& system, const State& state);
  const std::vector<Twist>& velocity() const { return velocity_; }
  // Sets the curve of a contact that lasts.
  void bend(const System& system, const State& state, const Attempt& attempt, Contact& c);

 private:
  std::vector<Twist> velocity_, acceleration_;  // per body; accelerations are found on demand
};

}  // namespace hp
