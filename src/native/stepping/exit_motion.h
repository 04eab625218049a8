// The motion of bodies that come out of an initial overlap (docs/physics.md, "Initial overlaps").
// Whereto and how fast they are to come is found by collision/depenetration.h; here is what that
// may do to the body.
//
// - A step: Depenetration::growth in [0, 1] is the share of the exit speed that is asked. Where a
//   step would make any point faster than the motion by kExitSpeed, or cannot be verified, it is
//   tried again with less, and with none after kExitTries.
// - Joints on the path from the root to the part that comes out resist as if they had 4 times their
//   inertia, all others 300 times (EffectiveInertia).
// - The person goes back to the motion gently until it is there (Drive::go_gently).
#pragma once
#include "stepping/data.h"

namespace hp {

class ExitMotion {
 public:
  // A substep attempt begins: the exit speed grows again. False if no body is inside of anything.
  bool begin(World& world);
  // After a try: true if it may stand. Otherwise Depenetration::growth is less.
  bool accept(System& system, Data& data);
  // All tries are spent: the next one asks for no motion out, finish() sets the speed for the next
  // substep.
  void give_up(World& world);
  void finish(World& world) const { world.depenetration.growth = kept_; }

 private:
  double excess_speed(System& system, Data& data);
  double fastest_point(System& system, Data& data, int shape, double least) const;

  double kept_ = 1;
  std::vector<Twist> twists_, asked_;
};

// Two people who are taken apart (collision/people_parting.h): the one who is displaced gets away from
// the other at the exit speed, in v*. After a substep of h [s]: how far they have come.
void part_people(const System& system, Data& data);
void finish_parting(System& system, const Data& data, double h);

// Marks the paths from roots to parts that are inside of something, besides those that are marked
// already; their people go back to the motion gently.
void start_exits(System& system, State& state);
// Is any part of this person inside of something that it started in?
bool comes_out(const System& system, const Drive& d);
// A frame has ended: people who are out, and back at the motion, are no longer gentle.
void end_gentle_frame(System& system, const State& state);

}  // namespace hp
