// What there is to collide, given as arrays: shapes of bodies, skins, static geometry, and what holds between pairs.
// After set_model and before finish (system_calls.h). All throw std::invalid_argument where arrays do not fit.
#pragma once
#include <memory>

#include "assembly/array_view.h"
#include "assembly/skin_shapes.h"
#include "stepping/stepper.h"

namespace hp::assembly {

// A static mesh in the world frame: its tree, shared by all that ask for the same triangles.
struct MeshTree {
  std::shared_ptr<const TriangleTree> tree;
};

// Vertices and normals of faces [m] in the frame of the body; see convex().
void add_shape(Stepper& s, int body, int name, int person, int part, Rows3 vertices, Rows3 normals,
               double radius, Doubles rim);
// Of the last shape: how far it sticks out of the surface that it stands for [m].
void set_slack(Stepper& s, double slack);
// Adds the shapes of a skin as person `person`; `names` (shapes,): their rows of material pairs.
void add_skin_shapes(Stepper& s, const SkinShapes& person_shapes, int person, Ints names);
void add_half_space(Stepper& s, int name, Doubles n, double offset);
void add_hull(Stepper& s, int name, Rows3 vertices, Rows3 normals, double radius, Doubles rim);
void add_mesh(Stepper& s, int name, const MeshTree& mesh);
// Names x names each.
void set_pairings(Stepper& s, Square friction, Square restitution, Square ignore);
// Pairs (n, 2) of one person's shapes that may touch each other, the smaller index first.
void set_self_pairs(Stepper& s, Square pairs);
// An object that sleeps after a reset until something touches it.
void start_asleep(Stepper& s, int body);
// Poses (K, 3), (K, 4) of a kinematic body, K of them `fps` to the second; see Trajectory.
void add_trajectory(Stepper& s, int body, double fps, bool loop, Rows3 position, Rows4 turn);

}  // namespace hp::assembly
