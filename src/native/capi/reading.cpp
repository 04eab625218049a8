// What came of a frame: poses, bodies, contacts, clearance.
#include <cmath>

#include "capi/world_handle.h"

using namespace hp;
using namespace hp::capi;

namespace {

void put_pose(double* out, Vec3 position, Quat turn) {
  store3(out, position);
  store4(out + 3, turn);
}

// Frame of an object at the stepper's pose; with the operations of FreeObject.pose in Python.
void object_pose(const ObjectPlace& o, const std::vector<double>& qpos, const Kinematics& at,
                 Vec3& position, Quat& turn) {
  const bool own = o.qpos >= 0;
  turn = own ? load4(&qpos[o.qpos + 3]) : at.xquat[o.body];
  position = (own ? load3(&qpos[o.qpos]) : at.xpos[o.body]) - turned(turn, o.com);
}

Kinematics kinematics(hp_world& w) {
  Kinematics at;
  at.resize(w.stepper().system.model);
  at.update(w.stepper().system.model, w.stepper().qpos().data());
  return at;
}

// A contact as the side of its shape has it, see simulation/core_rows.py.
hp_contact contact(const Labels& labels, const Touch& t, double dt) {
  hp_contact c{};
  const int first = labels.first_person(), name = labels.shape_name[t.shape];
  const bool human = name >= first;
  c.person = human ? name - first : -1;
  c.part = labels.shape_part[t.shape];
  c.subject = human ? -1 : name;
  const bool fixed = t.other_static >= 0;
  c.other = fixed ? labels.static_name[t.other_static] : labels.shape_name[t.other_shape];
  c.other_part = fixed ? -1 : labels.shape_part[t.other_shape];
  const double length = norm(t.normal);
  store3(c.position, t.weight > 0 ? (1 / t.weight) * t.position : t.position);
  store3(c.normal, length > 0 ? (1 / length) * t.normal : t.normal);
  store3(c.impulse, t.impulse);
  store3(c.force, dt > 0 ? (1 / dt) * t.impulse : Vec3{});
  return c;
}

// Of two people who touch the other side has a row of its own.
hp_contact twin(const Labels& labels, const hp_contact& c) {
  hp_contact o = c;
  o.person = c.other - labels.first_person(), o.part = c.other_part;
  o.other = labels.first_person() + c.person, o.other_part = c.part;
  for (int k = 0; k < 3; k++) {
    o.normal[k] = -c.normal[k], o.impulse[k] = -c.impulse[k], o.force[k] = -c.force[k];
  }
  return o;
}

}  // namespace

hp_status hp_get_pose(hp_world* world, int person, double* translation, double* rotations) {
  return guarded([&] {
    hp_world& w = running(world, "hp_get_pose");
    need(translation != nullptr && rotations != nullptr, HP_BAD_ARGUMENT,
         "hp_get_pose: translation or rotations is NULL");
    need(person >= 0 && person < hp_person_count(world), HP_NO_SUCH_NAME,
         "hp_get_pose: there is no such person");
    const PersonPlace& p = w.labels().people[person];
    const double* qpos = w.stepper().qpos().data();
    store3(translation, load3(qpos + p.qpos) - p.pelvis);
    for (int j = 0; j < kJoints; j++)
      store3(rotations + 3 * j, log_quat(load4(qpos + p.joint_qpos[j])));
  });
}

hp_status hp_get_bodies(hp_world* world, double* out) {
  return guarded([&] {
    hp_world& w = running(world, "hp_get_bodies");
    need(out != nullptr, HP_BAD_ARGUMENT, "hp_get_bodies: out is NULL");
    const Kinematics at = kinematics(w);
    for (const PersonPlace& p : w.labels().people)
      for (int b : p.body) put_pose(out, at.xpos[b], at.xquat[b]), out += 7;
    for (const ObjectPlace& o : w.labels().objects) {
      Vec3 position;
      Quat turn;
      object_pose(o, w.stepper().qpos(), at, position, turn);
      put_pose(out, position, turn), out += 7;
    }
    for (const LinkPlace& l : w.labels().links)
      put_pose(out, at.xpos[l.body], at.xquat[l.body]), out += 7;
  });
}

hp_status hp_get_object(hp_world* world, const char* name, double* position, double* quaternion) {
  return guarded([&] {
    hp_world& w = running(world, "hp_get_object");
    need(position != nullptr && quaternion != nullptr, HP_BAD_ARGUMENT,
         "hp_get_object: position or quaternion is NULL");
    const Kinematics at = kinematics(w);
    Vec3 x;
    Quat turn;
    if (const ObjectPlace* o = object(w, name, "hp_get_object")) {
      object_pose(*o, w.stepper().qpos(), at, x, turn);
    } else {
      const LinkPlace* link = nullptr;
      for (const LinkPlace& l : w.labels().links)
        if (l.name == name) link = &l;
      need(link != nullptr, HP_NO_SUCH_NAME,
           "hp_get_object: '" + std::string(name) + "' is no object and no link");
      x = at.xpos[link->body], turn = at.xquat[link->body];
    }
    store3(position, x);
    store4(quaternion, turn);
  });
}

hp_status hp_get_joint(hp_world* world, int joint, double* out, int* count) {
  return guarded([&] {
    hp_world& w = running(world, "hp_get_joint");
    need(out != nullptr && count != nullptr, HP_BAD_ARGUMENT, "hp_get_joint: out or count is NULL");
    need(joint >= 0 && joint < hp_joint_count(world), HP_NO_SUCH_NAME,
         "hp_get_joint: there is no such joint");
    const JointPlace& j = w.labels().joints[joint];
    std::copy_n(&w.stepper().qpos()[j.qpos], j.width, out);
    *count = j.width;
  });
}

hp_status hp_get_contacts(hp_world* world, hp_contact* out, size_t room, size_t* count) {
  return guarded([&] {
    hp_world& w = running(world, "hp_get_contacts");
    need(count != nullptr && (out != nullptr || room == 0), HP_BAD_ARGUMENT,
         "hp_get_contacts: out or count is NULL");
    const Labels& labels = w.labels();
    size_t n = 0;
    for (const Touch& t : w.stepper().result().touches) {
      const hp_contact c = contact(labels, t, w.dt);
      if (n < room) out[n] = c;
      n++;
      if (c.person < 0 || c.other < labels.first_person()) continue;
      if (n < room) out[n] = twin(labels, c);
      n++;
    }
    *count = n;
  });
}

hp_status hp_get_clearance(hp_world* world, double* out) {
  return guarded([&] {
    hp_world& w = running(world, "hp_get_clearance");
    need(out != nullptr, HP_BAD_ARGUMENT, "hp_get_clearance: out is NULL");
    *out = w.stepper().clearance();
  });
}

hp_status hp_get_lost_time(hp_world* world, double* out) {
  return guarded([&] {
    hp_world& w = running(world, "hp_get_lost_time");
    need(out != nullptr, HP_BAD_ARGUMENT, "hp_get_lost_time: out is NULL");
    *out = w.dt > 0 ? w.stepper().result().diagnostics.lost_time : 0.0;
  });
}
