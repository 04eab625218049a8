#include "compiled/world_check.h"

#include <cmath>
#include <stdexcept>

namespace hp {

namespace {

// Most shapes that move: pairs of them are kept in a table.
constexpr size_t kMostShapes = 20'000;
// Most rounds of the solver, and most substeps of a frame: what a file asks for is waited for. With 100,000
// substeps a frame in contact took minutes. Python refuses to write files of more (compile_world.py).
constexpr int kMostSweeps = 10'000, kMostSubsteps = 1'000;
// How far normals and quaternions may be from a length of 1 [-]: rounding of files that were edited.
constexpr double kUnit = 1e-6;

void expect(bool ok, const char* what) {
  if (!ok) throw std::invalid_argument(std::string("world file: ") + what);
}

bool below(int index, size_t count) { return index >= 0 && (size_t)index < count; }

void check_settings(const System& s) {
  const ContactSettings& c = s.world.settings;
  expect(c.clearance > 0 && c.tolerance > 0 && c.depenetration_speed >= 0 && c.max_sweeps > 0 &&
             c.max_sweeps <= kMostSweeps && s.clearance_range >= 0,
         "contact settings out of range");
  const DriveSettings& d = s.drive_settings;
  expect(d.time_constant >= 0 && d.recovery_rate >= 0 && d.root_speed >= 0 &&
             d.joint_damping >= 0 && d.torque_frequency >= 0 && d.torque_damping >= 0,
         "drive settings below 0");
}

void check_shapes(const CollisionWorld& w) {
  const size_t names = w.n_names;
  expect(w.shapes.size() <= kMostShapes, "too many shapes");
  for (const CollisionShape& s : w.shapes)
    expect(below(s.name, names) && s.part >= -1 && s.part < kJoints && s.person >= -1 &&
               s.hull.radius >= 0,
           "a shape of no name, part or person, or of a radius below 0");
  for (const Static& s : w.statics)
    expect(below(s.name, names) && s.hull.radius >= 0, "static geometry of no name");
  for (const Static& s : w.statics)
    expect(s.kind != Static::Kind::HalfSpace || std::fabs(norm(s.n) - 1) < kUnit,
           "a half-space whose normal is no unit vector");
  for (const Pairing& p : w.pairings)
    expect(p.friction >= 0 && p.restitution >= 0 && p.restitution <= 1,
           "friction or restitution out of range");
}

void check_people(const CompiledWorld& world) {
  const Labels& labels = world.labels;
  const System& s = world.stepper.system;
  expect(labels.people.size() == s.drives.size(), "another number of people than of drives");
  for (size_t i = 0; i < labels.people.size(); i++) {
    const PersonPlace& p = labels.people[i];
    const Drive& d = s.drives[i];
    expect(d.ball_count() == kJoints && p.root == d.body(0) && p.qpos == d.first_qpos() &&
               d.qpos_count() == 7 + 4 * (kJoints - 1),
           "a person of other joints than SMPL-X's");
    for (int j = 0; j < kJoints; j++)
      expect(p.joint_qpos[j] >= p.qpos + 3 && p.joint_qpos[j] <= p.qpos + d.qpos_count() - 4 &&
                 below(p.body[j], s.model.nbody) && below(p.ball[j], kJoints) &&
                 p.stiffness[j] >= 0,
             "a joint of a person that is none");
    for (double limit : d.limits) expect(limit >= 0, "a strength below 0");
  }
  for (const CollisionShape& shape : s.world.shapes)
    expect(shape.person < (int)s.drives.size(), "a shape of no person");
}

// A turn at the start: the one of a person comes with the first pose.
void check_turn(const Labels& labels, int qpos) {
  const Quat q = load4(&labels.start_qpos[qpos]);
  const double length2 = q.w * q.w + q.x * q.x + q.y * q.y + q.z * q.z;
  expect(std::fabs(length2 - 1) < kUnit, "a start whose quaternion is no unit");
}

void check_items(const CompiledWorld& world) {
  const Labels& labels = world.labels;
  const Model& m = world.stepper.system.model;
  for (const ObjectPlace& o : labels.objects) {
    expect(o.body > 0 && below(o.body, m.nbody) && labels.find(o.name) >= 0,
           "an object of no body");
    expect(
        o.qpos < 0 || (m.jnt_count[o.body] == 1 && m.jnt_type[m.jnt_first[o.body]] == Joint::Free &&
                       m.jnt_qpos[m.jnt_first[o.body]] == o.qpos && m.dof_first[o.body] == o.dof),
        "an object without coordinates");
    expect(o.qpos >= 0 || !o.pushable, "an object without coordinates");
    if (o.qpos >= 0) check_turn(labels, o.qpos + 3);
  }
  for (const LinkPlace& l : labels.links)
    expect(l.body > 0 && below(l.body, m.nbody) && labels.find(l.name) >= 0, "a link of no body");
  for (const JointPlace& j : labels.joints) {
    expect(
        (j.width == 1 || j.width == 4 || j.width == 7) && j.qpos >= 0 && j.qpos <= m.nq - j.width,
        "a joint without coordinates");
    if (j.width >= 4) check_turn(labels, j.qpos + j.width - 4);
  }
}

void check_labels(const CompiledWorld& world) {
  const Labels& labels = world.labels;
  const System& s = world.stepper.system;
  const size_t names = labels.everything.size(), rows = s.world.n_names;
  expect(labels.people.size() <= names && rows >= names, "fewer names than people");
  expect(labels.shape_name.size() == s.world.shapes.size() &&
             labels.shape_part.size() == s.world.shapes.size() &&
             labels.static_name.size() == s.world.statics.size(),
         "another number of names than of shapes");
  for (int name : labels.shape_name) expect(below(name, names), "a shape of no name");
  for (int name : labels.static_name) expect(below(name, names), "static geometry of no name");
  for (int part : labels.shape_part) expect(part >= -1 && part < kJoints, "a shape of no part");
  expect((int)labels.start_qpos.size() == s.model.nq && (int)labels.start_qvel.size() == s.model.nv,
         "a start of another number of coordinates");
  expect(labels.substeps >= 0 && labels.substeps <= kMostSubsteps, "substeps out of range");
  expect(labels.own_friction.size() == rows && labels.own_pair.size() == rows * rows,
         "another number of frictions than of names");
}

}  // namespace

void check_before_finish(const System& system) {
  check_settings(system);
  expect(system.world.pairings.size() == (size_t)system.world.n_names * system.world.n_names,
         "no table of pairs");
  check_shapes(system.world);
}

void check_world(const CompiledWorld& world) {
  check_labels(world);
  check_people(world);
  check_items(world);
}

}  // namespace hp
