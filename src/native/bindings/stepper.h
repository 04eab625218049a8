// The parts that the Python face of the stepper is bound in, each one group of its methods.
#pragma once
#include "assembly/shape_calls.h"
#include "assembly/system_calls.h"
#include "bindings/arrays.h"
#include "stepping/stepper.h"

using StepperClass = nb::class_<hp::Stepper>;

// Each in the file of its name:
void bind_stepper_system(StepperClass& stepper);  // model, settings, strength
void bind_skin_shapes(nb::module_& m);
void bind_batch(nb::module_& m);                   // whole motions on threads
void bind_hosted_world(nb::module_& m);            // people in another engine's world
void bind_fleet(nb::module_& m);                   // many worlds, a frame at a time, on threads
void bind_stepper_shapes(StepperClass& stepper);   // shapes, static geometry, pairs of them
void bind_stepper_frames(StepperClass& stepper);   // reset, frames, snapshots
void bind_stepper_results(StepperClass& stepper);  // poses, contacts, clearances
// Looks inside the stepper, for tests and measurements (probes.cpp).
void bind_probes(nb::module_& m, StepperClass& stepper);

namespace hp {

// Columns: shape, other static, other shape, position, normal, impulse.
void touch_rows(const std::vector<Touch>& touches, std::vector<double>& out);
// Columns: layer's static, layer's shape, shape, sample, position, normal, depth [m], pressure [Pa],
// projected area [m^2].
constexpr size_t kSoftColumns = 13;
void soft_rows(const std::vector<SoftPoint>& points, std::vector<double>& out);
// Columns: shape, static, other shape, depth [m].
void inside_rows(const World& world, std::vector<double>& out);
// The same of overlaps that should not be.
void breach_rows(const std::vector<Breach>& breaches, std::vector<double>& out);

}  // namespace hp
