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
// person is not pushed: its legs carry it. Friction at its soles is a matter of the contacts' solve
// (standing_friction.h). Where contacts between a person and movable things
// already press on them, the load is less by as much.
#pragma once
#include <vector>

#include "stepping/data.h"

namespace hp {

// What a person presses down with if nothing else carries it [N].
inline double weight_of(const System& system, const Drive& d) {
  return system.model.carried[d.body(0)] * norm(system.gravity);
}

// A shape of a person's body, or of what it hangs on if it has none; 0 if nothing of it has any.
int pressing_shape(const System& system, int body);

// Calls `act(i, body, share)` for whatever movable thing a person presses on with point i of its bearing, with
// that share of its weight.
template <class Act>
void for_loads(const System& system, const Drive& d, Act act) {
  const Bearing& bearing = d.footing.bearing;
  if (weight_of(system, d) <= 0) return;
  for (size_t i = 0; i < bearing.points.size(); i++) {
    const BearingPoint& p = bearing.points[i];
    if (p.shape < 0 || bearing.load(i) <= 0) continue;
    const int body = system.world.shapes[p.shape].body;
    if (!system.is_person(body) && system.world.active[body]) act(i, body, bearing.load(i));
  }
}

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
    int person;  // and that of the person that presses
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
