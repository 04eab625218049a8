// Sleeping objects: objects that start asleep stay where they are, with no gravity and no contact
// with static geometry or other sleeping objects, until something touches them.
//
// Everything else meets a sleeping object as the free body that it is: the first impulse on it
// wakes it, with all sleeping objects within kWakeRange clearances of it, and the step is made
// again, so that it is never a wall, not even for one substep.
#pragma once
#include "stepping/data.h"

namespace hp {

// Wakes the objects that the last solve of an attempt found touched, and those that lie on them;
// gives them their free velocity. True if there were any: then the step is to be tried again.
bool wake_touched(System& system, Data& data);

// Wakes all sleeping objects that lie within kWakeRange clearances of `woken` (per root body) or of what
// they wake, which joins them. Does not give them their free velocity.
void wake_neighbours(System& system, Data& data, std::vector<char>& woken);

// Sleeping objects have no velocity, into step.v_free.
void hold_asleep(const System& system, Step& step);

}  // namespace hp
