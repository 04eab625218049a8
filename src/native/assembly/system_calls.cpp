#include "assembly/system_calls.h"

#include "assembly/model_check.h"

namespace hp::assembly {

void set_model(Stepper& s, Ints parent, Ints jnt_first, Ints jnt_count, Ints dof_first,
               Ints dof_count, Rows3 pos, Rows4 quat, Rows3 ipos, Rows4 iquat, Doubles mass,
               Rows3 inertia, Ints jnt_type, Ints jnt_qpos, Ints jnt_dof, Ints jnt_body,
               Rows3 jnt_pos, Rows3 jnt_axis, Doubles qpos0, Doubles armature) {
  Model& m = s.system.model;
  m = {};
  m.nbody = (int)parent.shape(0);
  m.njnt = (int)jnt_type.shape(0);
  m.nq = (int)qpos0.shape(0);
  m.nv = (int)armature.shape(0);
  m.parent = list<int>(parent);
  m.jnt_first = list<int>(jnt_first);
  m.jnt_count = list<int>(jnt_count);
  m.dof_first = list<int>(dof_first);
  m.dof_count = list<int>(dof_count);
  m.pos = vectors(pos);
  m.quat = quats(quat);
  m.ipos = vectors(ipos);
  m.iquat = quats(iquat);
  m.mass = list<double>(mass);
  m.inertia = vectors(inertia);
  for (int t : list<int>(jnt_type)) m.jnt_type.push_back(static_cast<Joint>(t));
  m.jnt_qpos = list<int>(jnt_qpos);
  m.jnt_dof = list<int>(jnt_dof);
  m.jnt_body = list<int>(jnt_body);
  m.jnt_pos = vectors(jnt_pos);
  m.jnt_axis = vectors(jnt_axis);
  m.qpos0 = list<double>(qpos0);
  m.armature = list<double>(armature);
  check_model(m);
  m.finish();
}

void set_joint_forces(Stepper& s, Doubles damping, Doubles stiffness, Doubles spring, Ints limited,
                      Rows2 range) {
  const Model& m = s.system.model;
  need((int)damping.shape(0) == m.nv && (int)stiffness.shape(0) == m.njnt &&
           (int)spring.shape(0) == m.nq && (int)limited.shape(0) == m.njnt &&
           (int)range.shape(0) == m.njnt,
       "set_joint_forces: arrays that do not fit the model");
  JointForces& f = s.system.articulations.joints;
  f.damping = list<double>(damping), f.stiffness = list<double>(stiffness);
  f.spring = list<double>(spring);
  f.limited.assign(m.njnt, 0), f.lower.assign(m.njnt, 0), f.upper.assign(m.njnt, 0);
  for (int j = 0; j < m.njnt; j++) {
    f.limited[j] = limited.data()[j] != 0;
    f.lower[j] = range.data()[2 * j], f.upper[j] = range.data()[2 * j + 1];
  }
}

void set_drive(Stepper& s, double time_constant, double recovery_rate, bool recover_root,
               double root_speed) {
  DriveSettings& d = s.system.drive_settings;
  d.time_constant = time_constant, d.recovery_rate = recovery_rate;
  d.recover_root = recover_root, d.root_speed = root_speed;
}

void set_contact(Stepper& s, double clearance, double clearance_range, double depenetration_speed,
                 double tolerance, int max_sweeps, Doubles gravity) {
  need(gravity.shape(0) == 3, "set_contact: gravity must be (3,)");
  s.system.world.settings = {clearance, depenetration_speed, tolerance, max_sweeps};
  s.system.clearance_range = clearance_range;
  s.system.gravity = load3(gravity.data());
}

void set_baselines(Stepper& s, bool internal_forces, double joint_damping, double torque_frequency,
                   double torque_damping) {
  DriveSettings& d = s.system.drive_settings;
  d.internal_forces = internal_forces, d.joint_damping = joint_damping;
  d.torque_frequency = torque_frequency, d.torque_damping = torque_damping;
}

void set_prescribed(Stepper& s, int how) {
  need(how >= 0 && how <= 3, "set_prescribed: no such way");
  s.system.prescribed = static_cast<Prescribed>(how);
  s.system.world.forced = how > 0;
}

void finish(Stepper& s, const std::vector<int>& person_roots) {
  // Hulls point at their own shapes: only now do the statics stop moving in memory.
  for (Static& v : s.system.world.statics)
    if (v.kind == Static::Kind::Hull) v.posed.place(v.hull, {}, {});
  s.finish(person_roots);
}

}  // namespace hp::assembly

namespace hp {

int target_count(const Stepper& s) {
  int count = 0;
  for (const Drive& d : s.system.drives) count += d.qpos_count();
  return count;
}

void set_stiffness(Stepper& s, const double* lambda) {
  for (Drive& d : s.system.drives) {
    d.set_stiffness(lambda);
    lambda += d.ball_count();
  }
}

}  // namespace hp
