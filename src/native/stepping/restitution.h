// Restitution: a contact that arrived fast enough rebounds with e times its speed (Newton's law).
//
// The rebound starts where the substep does, above the surface, and before gravity has acted: the
// speed demanded is that of the parabola which meets the surface and leaves it e times as fast.
// With v_n the normal velocity at arrival, g_n its change by gravity in the substep and d the gap
// to go,
//
//   height = 2 g_n d / h,   met = v_n - g_n/2,   back^2 = e^2 (met^2 + height) - height
//
// and the contact demands  v_n' = back - g_n/2  in a second solve (Contact::bounce [m/s]).
#pragma once
#include "stepping/data.h"

namespace hp {

// Sets the demands of contacts that rebound in a step of length h [s]; false if none does.
bool demand_rebounds(const System& system, Data& data, double h);

}  // namespace hp
