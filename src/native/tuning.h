// Every tuning constant of the native core, each once (as in Jolt's PhysicsSettings.h).
//
// A tuning constant is a number that was chosen: a tolerance, a limit of iterations, a margin, a
// time, a speed. Not here: numbers of mathematics (pi, the number of vertices of a box), sizes of
// layouts (rows of four), and settings that a caller chooses (`Settings` of the package).
//
// Each states, in this order: what it is and its unit in brackets ([-] is left out for counts and
// ratios); what was measured to choose it, where it was; and what goes wrong below and beyond it.
// Measurements are told at length in docs/physics.md.
//
// Units are SI: [m], [s], [kg], [rad], [N s]. `2` at the end of a name means squared.
//
// Names are unique in the whole file, so that a name has one meaning; code writes the section, as
// in `tuning::contact::kNewtonSteps`. Python reads those that it shares from `halfphysics._native.tuning`
// (bindings/tuning.cpp): it never repeats a number.
#pragma once
#include <cstddef>

namespace hp::tuning::dynamics {

}  // namespace hp::tuning::dynamics

// ---------------------------------------------------------------------------------------------

namespace hp::tuning::geometry {

// convex.cpp

// bvh.cpp

// triangle_cluster.h, triangle_tree.h

// winding.cpp

// skinning.cpp

}  // namespace hp::tuning::geometry

// ---------------------------------------------------------------------------------------------

namespace hp::tuning::collision {

// Broad phase

// Narrow phase

// Contact points

// Clearances

// Self-contact

// Depenetration: the way out of what a motion starts inside of

}  // namespace hp::tuning::collision

// ---------------------------------------------------------------------------------------------

namespace hp::tuning::contact {

// Newton's method for Coulomb friction (contact_problem.cpp, coulomb.cpp)

// Islands and the contacts that take part (solver.cpp)

}  // namespace hp::tuning::contact

// ---------------------------------------------------------------------------------------------

namespace hp::tuning::stepping {

// The substep: planes, contacts, solve, verify, shorten or commit

// Sub-stepping

// Drive

// Kinematic bodies and held objects

// Strength, self-contact

// Depenetration, sleeping

}  // namespace hp::tuning::stepping

// ---------------------------------------------------------------------------------------------

namespace hp::tuning::labels {

}  // namespace hp::tuning::labels

// ---------------------------------------------------------------------------------------------

namespace hp::tuning::render {

}  // namespace hp::tuning::render
