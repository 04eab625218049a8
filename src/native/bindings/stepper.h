// The parts that the Python face of the stepper is bound in, each one group of its methods.
#pragma once
#include "bindings/arrays.h"
#include "stepping/stepper.h"

// A person's skin and the hulls that collide, derived once: steppers in which the person's bodies
// have the same numbers share them.
struct SkinShapes {
  std::shared_ptr<const hp::Skin> skin;
  std::vector<hp::CollisionShape> shapes;
};

using StepperClass = nb::class_<hp::Stepper>;

// A static mesh in the world frame: its tree, shared by all that ask for the same triangles.
struct MeshTree {
  std::shared_ptr<const hp::TriangleTree> tree;
};

// Each in the file of its name:
void bind_stepper_system(StepperClass& stepper);  // model, settings, strength
void bind_skin_shapes(nb::module_& m);
void bind_batch(nb::module_& m);                   // whole motions on threads
void bind_fleet(nb::module_& m);                   // many worlds, a frame at a time, on threads
void bind_stepper_shapes(StepperClass& stepper);   // shapes, static geometry, pairs of them
void bind_stepper_frames(StepperClass& stepper);   // reset, frames, hosting, snapshots
void bind_stepper_results(StepperClass& stepper);  // poses, contacts, clearances
// Looks inside the stepper, for tests and measurements (probes.cpp).
void bind_probes(nb::module_& m, StepperClass& stepper);

namespace hp {

// Columns: shape, other static, other shape, position, normal, impulse.
void touch_rows(const std::vector<Touch>& touches, std::vector<double>& out);
// Columns: shape, static, other shape, depth [m].
void inside_rows(const World& world, std::vector<double>& out);
// The same of overlaps that should not be.
void breach_rows(const std::vector<Breach>& breaches, std::vector<double>& out);
// Numbers of targets of all people together.
int target_count(const Stepper& s);
// lambda of every ball of all people, in the model's order.
void set_stiffness(Stepper& s, const double* lambda);

}  // namespace hp
