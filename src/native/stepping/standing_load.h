// Standing load: who stands, sits or lies on a movable thing weighs on it.
//
// A person is moved by a drive, and what carries it is found before a frame (footing/): no contact has to hold
// it up, so none presses on what is under it. In its place a substep's free velocity has the load: at
// every point i that rests on a movable thing (footing/bearing.h) the force
//
//   F_i = share_i m g,   v* += M^^-1 h sum J_i^T F_i
//
// on that thing alone, M^ with the springs and damping of articulated objects. What this makes things do, such as
// pressing on the floor, is left to contacts. Static geometry takes its share and needs no force. The
// person is not pushed: its legs carry it. Where contacts between a person and movable things
// already press on them, the load is less by as much.
#pragma once
#include <vector>

#include "stepping/data.h"

namespace hp {

class StandingLoad {
 public:
  // Wakes sleeping objects that somebody stands on. Before the free velocity of a substep.
  void wake(System& system, Data& data) const;
  // Adds what the loads make of v* in a substep of length h, into step.v_free and step.load.
  void add(System& system, Data& data, double h);
  // A time h passes: what people press with on movable things meanwhile, appended to `out`. For a
  // world that another engine moves (hosting.h), which adds it to its forces itself.
  struct Pressing {
    int shape;   // of the thing
    int person;  // the body of the person that presses
    Vec3 at;
    Vec3 force;  // on the thing [N]
  };
  static void pressing(System& system, double h, std::vector<Pressing>& out);
  // After a frame of length dt: what contacts have pressed with.
  static void end_frame(System& system, const FrameResult& result, double dt);

 private:
  std::vector<double> impulse_;  // per dof, then the change of velocity that it makes
};

}  // namespace hp
