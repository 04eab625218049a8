// The model, the settings and the drives of a stepper, given as arrays: what Python's bindings and the reader of
// world files (compiled/replay.h) call. All throw std::invalid_argument where arrays do not fit.
//
// The order of the calls: set_model, set_joint_forces, shapes (shape_calls.h), settings, trajectories, finish, limits
// (limit_calls.h).
#pragma once
#include "assembly/array_view.h"
#include "stepping/stepper.h"

namespace hp::assembly {

// The arrays of an MjModel, under its names for them where it has one.
void set_model(Stepper& s, Ints parent, Ints jnt_first, Ints jnt_count, Ints dof_first,
               Ints dof_count, Rows3 pos, Rows4 quat, Rows3 ipos, Rows4 iquat, Doubles mass,
               Rows3 inertia, Ints jnt_type, Ints jnt_qpos, Ints jnt_dof, Ints jnt_body,
               Rows3 jnt_pos, Rows3 jnt_axis, Doubles qpos0, Doubles armature);
// In the order of set_model: per dof, per joint, per coordinate, and two per joint.
void set_joint_forces(Stepper& s, Doubles damping, Doubles stiffness, Doubles spring, Ints limited,
                      Rows2 range);
// See DriveSettings.
void set_drive(Stepper& s, double time_constant, double recovery_rate, bool recover_root,
               double root_speed);
// See ContactSettings and System.
void set_contact(Stepper& s, double clearance, double clearance_range, double depenetration_speed,
                 double tolerance, int max_sweeps, Doubles gravity);
// Forces and torques to compare with, see DriveSettings.
void set_baselines(Stepper& s, bool internal_forces, double joint_damping, double torque_frequency,
                   double torque_damping);
// Before finish(): people's poses are set, see Prescribed.
void set_prescribed(Stepper& s, int how);
// `person_roots`: the root body of every person. Makes the people's drives.
void finish(Stepper& s, const std::vector<int>& person_roots);

}  // namespace hp::assembly

namespace hp {

// lambda of every ball of all people, in the model's order, roots (ignored) included.
void set_stiffness(Stepper& s, const double* lambda);
// Numbers of targets of all people together.
int target_count(const Stepper& s);

}  // namespace hp
