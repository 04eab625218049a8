// Limits of what people exert and how far joints go, and what they stand on: after finish() (system_calls.h).
// All throw std::invalid_argument where arrays do not fit.
#pragma once
#include "assembly/array_view.h"
#include "stepping/stepper.h"

namespace hp::assembly {

// Per person the root's force [N], then the torque of every ball joint [N m]; inf: no limit.
void set_strength(Stepper& s, int person, Doubles limits);
// Per ball joint of a person: axes (n, 3, 3), twist, flexion, abduction; ends of the three angles (n, 3)
// [rad]; all flat.
void set_joint_ranges(Stepper& s, int person, Doubles axes, Doubles lower, Doubles upper);
// People who are blocked wait: see ReferenceClock.
void set_waiting(Stepper& s, bool on);
// Person `person` stands on what is under it: see Footing. `joints`: hip, knee and ankle (bodies) of
// every leg, with the ranges that they have by then, whose soles are the next `soles` points; the
// last `hands` are of hands, the rest of other skin.
void set_footing(Stepper& s, int person, Faces joints, Ints soles, int hands, Ints body,
                 Doubles weight, Rows3 local, Rows3 normal);

}  // namespace hp::assembly
