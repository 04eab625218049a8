// The stepper's model, settings, drives and joint forces. Settings are bound by name.
#include "bindings/stepper.h"

using namespace hp;
using namespace nb::literals;

namespace {

// The arrays of an MjModel, under its names for them where it has one.
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
  m.finish();
}

// In the order of set_model: per dof, per joint, per coordinate, and two per joint.
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

// Per person the root's force [N], then the torque of every ball joint [N m]; inf: no limit.
void set_strength(Stepper& s, int person, Doubles limits) {
  std::vector<Drive>& drives = s.system.drives;
  need(person >= 0 && person < (int)drives.size() &&
           (int)limits.shape(0) == drives[person].ball_count() + 1,
       "set_strength: bad person or length");
  drives[person].limits = list<double>(limits);
}

// Per ball joint of a person: axes (n, 3, 3), twist, flexion, abduction; ends of the three angles (n, 3)
// [rad]; all flat.
void set_joint_ranges(Stepper& s, int person, Doubles axes, Doubles lower, Doubles upper) {
  std::vector<Drive>& drives = s.system.drives;
  need(person >= 0 && person < (int)drives.size(), "set_joint_ranges: bad person");
  const size_t n = drives[person].ball_count();
  need(axes.size() == 9 * n && lower.size() == 3 * n && upper.size() == 3 * n,
       "set_joint_ranges: axes (n, 3, 3), lower (n, 3), upper (n, 3)");
  std::vector<JointRange> ranges(n);
  for (size_t i = 0; i < n; i++) {
    for (int k = 0; k < 3; k++) {
      ranges[i].axis[k] = load3(axes.data() + 9 * i + 3 * k);
      ranges[i].lower[k] = lower.data()[3 * i + k];
      ranges[i].upper[k] = upper.data()[3 * i + k];
    }
    ranges[i].finish();
  }
  drives[person].ranges = std::move(ranges);
}

// Skin points (n,) of a person: two bodies each, their weights, where they are in their frames, and the
// normal in the first's frame.
std::vector<SkinPoint> skin_points(const Stepper& s, Ints body, Doubles weight, Rows3 local,
                                   Rows3 normal) {
  const size_t n = normal.shape(0);
  need(body.shape(0) == 2 * n && weight.shape(0) == 2 * n && local.shape(0) == 2 * n,
       "skin points: arrays of different lengths");
  std::vector<SkinPoint> out(n);
  for (size_t i = 0; i < 2 * n; i++) {
    SkinPoint& p = out[i / 2];
    p.body[i % 2] = body.data()[i];
    need(p.body[i % 2] > 0 && p.body[i % 2] < s.system.model.nbody, "skin points: no such body");
    p.weight[i % 2] = weight.data()[i];
    p.local[i % 2] = load3(local.data() + 3 * i);
    p.normal = load3(normal.data() + 3 * (i / 2));
  }
  return out;
}

// Person `person` stands on what is under it: see Footing. `joints`: hip, knee and ankle (bodies) of
// every leg, with the ranges that they have by then, whose soles are the next `soles` points; the last `hands` are of hands, the rest of other skin.
void set_footing(Stepper& s, int person, Faces joints, Ints soles, int hands, Ints body,
                 Doubles weight, Rows3 local, Rows3 normal) {
  const Model& m = s.system.model;
  need(person >= 0 && person < (int)s.system.drives.size() && joints.shape(0) == soles.shape(0),
       "set_footing: bad person or length");
  auto model = std::make_shared<FootingModel>();
  const std::vector<SkinPoint> points = skin_points(s, body, weight, local, normal);
  auto next = points.begin();
  for (size_t f = 0; f < joints.shape(0); f++) {
    Leg leg;
    int* bodies[] = {&leg.hip, &leg.knee, &leg.ankle};
    int* quats[] = {&leg.hip_qpos, &leg.knee_qpos, &leg.ankle_qpos};
    for (int k = 0; k < 3; k++) {
      const int b = joints.data()[3 * f + k];
      need(b > 0 && b < m.nbody && m.plain_ball[b], "set_footing: no such joint");
      *bodies[k] = b, *quats[k] = m.jnt_qpos[m.jnt_first[b]];
      const Drive& d = s.system.drives[person];
      for (int ball = 0; ball < d.ball_count() && !d.ranges.empty(); ball++)
        if (d.body(ball) == b) leg.ranges.push_back(d.ranges[ball]);
    }
    need(leg.ranges.empty() || leg.ranges.size() == 3, "set_footing: no such joint");
    leg.root = m.parent[leg.hip];
    for (int b = 1; b < m.nbody; b++)
      if (m.parent[b] == leg.ankle) leg.toes = b;
    need(soles.data()[f] > 0 && points.end() - next >= soles.data()[f],
         "set_footing: too few points");
    leg.sole.assign(next, next + soles.data()[f]);
    next += soles.data()[f];
    model->legs.push_back(leg);
  }
  need(hands >= 0 && points.end() - next >= hands, "set_footing: too few points");
  model->skin.assign(next, points.end() - hands);
  model->hands.assign(points.end() - hands, points.end());
  s.system.drives[person].footing.model = model;
}

void finish(Stepper& s, std::vector<int> person_roots) {
  // Hulls point at their own shapes: only now do the statics stop moving in memory.
  for (Static& v : s.system.world.statics)
    if (v.kind == Static::Kind::Hull) v.posed.place(v.hull, {}, {});
  s.finish(person_roots);
}

}  // namespace

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

void bind_stepper_system(StepperClass& stepper) {
  stepper
      .def("set_model", &set_model, nb::kw_only(), "parent"_a, "jnt_first"_a, "jnt_count"_a,
           "dof_first"_a, "dof_count"_a, "pos"_a, "quat"_a, "ipos"_a, "iquat"_a, "mass"_a,
           "inertia"_a, "jnt_type"_a, "jnt_qpos"_a, "jnt_dof"_a, "jnt_body"_a, "jnt_pos"_a,
           "jnt_axis"_a, "qpos0"_a, "armature"_a)
      .def("set_joint_forces", &set_joint_forces, nb::kw_only(), "damping"_a, "stiffness"_a,
           "spring"_a, "limited"_a, "range"_a)
      // See DriveSettings.
      .def("set_drive", &set_drive, nb::kw_only(), "time_constant"_a, "recovery_rate"_a,
           "recover_root"_a, "root_speed"_a)
      // See ContactSettings and System.
      .def("set_contact", &set_contact, nb::kw_only(), "clearance"_a, "clearance_range"_a,
           "depenetration_speed"_a, "tolerance"_a, "max_sweeps"_a, "gravity"_a)
      // Forces and torques to compare with, see DriveSettings.
      .def("set_baselines", &set_baselines, nb::kw_only(), "internal_forces"_a, "joint_damping"_a,
           "torque_frequency"_a, "torque_damping"_a)
      // Before finish(): people's poses are set, see Prescribed.
      .def("set_prescribed", &set_prescribed)
      .def("finish", &finish)
      // lambda of every ball joint of all people, in the model's order, roots (ignored) included.
      .def("set_stiffness",
           [](Stepper& s, Doubles lambda) {
             need((int)lambda.shape(0) == s.system.ball_count(), "set_stiffness: bad length");
             set_stiffness(s, lambda.data());
           })
      .def("stiffness",
           [](Stepper& s) {
             std::vector<double> out;
             for (const Drive& d : s.system.drives)
               out.insert(out.end(), d.stiffness().begin(), d.stiffness().end());
             return array(out);
           })
      .def("set_strength", &set_strength)
      .def("set_joint_ranges", &set_joint_ranges, "person"_a, nb::kw_only(), "axes"_a, "lower"_a,
           "upper"_a)
      // People who are blocked wait: see ReferenceClock. After finish().
      .def("set_waiting",
           [](Stepper& s, bool on) {
             for (Drive& d : s.system.drives) d.clock.on = on;
           })
      .def("set_footing", &set_footing, nb::kw_only(), "person"_a, "joints"_a, "soles"_a, "hands"_a,
           "body"_a, "weight"_a, "local"_a, "normal"_a)
      .def("person_qpos", [](Stepper& s, int p) { return s.system.drives.at(p).first_qpos(); })
      .def("person_qpos_count",
           [](Stepper& s, int p) { return s.system.drives.at(p).qpos_count(); });
}
