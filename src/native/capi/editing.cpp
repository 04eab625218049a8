// What changes while a world runs: stiffness, masses, friction, velocities. simulation/live_edits.py is the same in Python.
#include <algorithm>

#include "assembly/system_calls.h"
#include "capi/world_handle.h"

using namespace hp;
using namespace hp::capi;

namespace {

constexpr double kMostMass = 1e6, kMostFriction = 1e3, kMostStiffness = 1e9;

// Velocity of an object's centre of mass in the world and its spin in its own axes.
struct Six {
  double v[6];
};

Six velocities(hp_world& w, const ObjectPlace& o) {
  Six six;
  std::copy_n(&w.stepper().qvel()[o.dof], 6, six.v);
  return six;
}

Quat turn(hp_world& w, const ObjectPlace& o) { return load4(&w.stepper().qpos()[o.qpos + 3]); }

// Friction of a row of material pairs with all others: the smaller of two.
void set_row(Labels& labels, World& w, int row, double friction) {
  const int n = w.n_names;
  labels.own_friction[row] = friction;
  for (int other = 0; other < n; other++) {
    if (labels.own_pair[row * n + other]) continue;
    const double both = std::min(friction, labels.own_friction[other]);
    w.pairings[row * n + other].friction = w.pairings[other * n + row].friction = both;
  }
}

}  // namespace

hp_status hp_set_stiffness(hp_world* world, int person, const double* stiffness) {
  return guarded([&] {
    hp_world& w = running(world, "hp_set_stiffness");
    need(person >= -1 && person < hp_person_count(world), HP_NO_SUCH_NAME,
         "hp_set_stiffness: there is no such person");
    need(stiffness != nullptr, HP_BAD_ARGUMENT, "hp_set_stiffness: stiffness is NULL");
    for (int j = 0; j < kJoints; j++)
      need(stiffness[j] >= 0 && stiffness[j] <= kMostStiffness, HP_BAD_ARGUMENT,
           "hp_set_stiffness: found " + std::to_string(stiffness[j]) + ", expected 0 to 1e9");
    const std::vector<PersonPlace>& people = w.labels().people;
    for (size_t i = 0; i < people.size(); i++) {
      if (person >= 0 && (size_t)person != i) continue;
      std::vector<double> core;
      for (int ball : people[i].ball) core.push_back(stiffness[ball]);
      w.stepper().system.drives[i].set_stiffness(core.data());
    }
  });
}

hp_status hp_set_mass(hp_world* world, const char* name, double mass) {
  return guarded([&] {
    need(world != nullptr, HP_BAD_ARGUMENT, "hp_set_mass: the world is NULL");
    ObjectPlace& o = free_object(*world, name, "hp_set_mass");
    check_positive(mass, kMostMass, "hp_set_mass: mass");
    Model& m = world->stepper().system.model;
    const double factor = mass / m.mass[o.body];
    m.mass[o.body] = m.carried[o.body] = mass;
    m.inertia[o.body] = factor * m.inertia[o.body];
    for (double& x : o.inertia.m) x *= factor;
  });
}

hp_status hp_get_mass(hp_world* world, const char* name, double* mass) {
  return guarded([&] {
    need(world != nullptr && mass != nullptr, HP_BAD_ARGUMENT,
         "hp_get_mass: the world or mass is NULL");
    const ObjectPlace& o = free_object(*world, name, "hp_get_mass");
    *mass = world->stepper().system.model.mass[o.body];
  });
}

hp_status hp_set_friction(hp_world* world, const char* name, double friction) {
  return guarded([&] {
    need(world != nullptr && name != nullptr, HP_BAD_ARGUMENT,
         "hp_set_friction: the world or the name is NULL");
    need(friction >= 0 && friction <= kMostFriction, HP_BAD_ARGUMENT,
         "hp_set_friction: found " + std::to_string(friction) + ", expected 0 to 1000");
    const int row = world->labels().find(name);
    need(row >= 0, HP_NO_SUCH_NAME,
         "hp_set_friction: there is nothing called '" + std::string(name) + "'");
    Labels& labels = world->compiled->labels;
    World& w = world->stepper().system.world;
    set_row(labels, w, row, friction);
    // Parts of people that the scene sets apart have rows of their own, after the names.
    if (row >= labels.first_person())
      for (int part = (int)labels.everything.size(); part < w.n_names; part++)
        set_row(labels, w, part, friction);
  });
}

hp_status hp_get_velocity(hp_world* world, const char* name, double* velocity,
                          double* angular_velocity) {
  return guarded([&] {
    hp_world& w = running(world, "hp_get_velocity");
    need(velocity != nullptr && angular_velocity != nullptr, HP_BAD_ARGUMENT,
         "hp_get_velocity: velocity or angular_velocity is NULL");
    const ObjectPlace* o = object(w, name, "hp_get_velocity");
    need(o != nullptr && o->qpos >= 0, HP_NO_SUCH_NAME,
         "hp_get_velocity: '" + std::string(name) + "' has no velocity of its own");
    const Quat q = turn(w, *o);
    const Six six = velocities(w, *o);
    const Vec3 spin = turned(q, load3(six.v + 3));
    store3(velocity, load3(six.v) - cross(spin, turned(q, o->com)));
    store3(angular_velocity, spin);
  });
}

hp_status hp_set_velocity(hp_world* world, const char* name, const double* velocity,
                          const double* angular_velocity) {
  return guarded([&] {
    hp_world& w = running(world, "hp_set_velocity");
    const ObjectPlace& o = free_object(w, name, "hp_set_velocity");
    check_numbers(velocity, 3, "hp_set_velocity: velocity");
    if (angular_velocity) check_numbers(angular_velocity, 3, "hp_set_velocity: angular_velocity");
    const Quat q = turn(w, o);
    const Vec3 spin =
        angular_velocity ? load3(angular_velocity) : turned(q, load3(velocities(w, o).v + 3));
    Six six;
    store3(six.v, load3(velocity) + cross(spin, turned(q, o.com)));
    store3(six.v + 3, turned(conjugate(q), spin));
    w.stepper().set_velocity(o.body, six.v);
  });
}

hp_status hp_apply_impulse(hp_world* world, const char* name, const double* impulse,
                           const double* point) {
  return guarded([&] {
    hp_world& w = running(world, "hp_apply_impulse");
    const ObjectPlace& o = free_object(w, name, "hp_apply_impulse");
    check_numbers(impulse, 3, "hp_apply_impulse: impulse");
    if (point) check_numbers(point, 3, "hp_apply_impulse: point");
    const Vec3 p = load3(impulse), centre = load3(&w.stepper().qpos()[o.qpos]);
    const Vec3 turning = point ? cross(load3(point) - centre, p) : Vec3{};
    Six six = velocities(w, o);
    const double mass = w.stepper().system.model.mass[o.body];
    for (int k = 0; k < 3; k++) six.v[k] += p[k] / mass;
    store3(six.v + 3, load3(six.v + 3) + solve3(o.inertia, turned(conjugate(turn(w, o)), turning)));
    w.stepper().set_velocity(o.body, six.v);
  });
}

hp_status hp_set_axes(hp_world* world, int person, const double* axes) {
  return guarded([&] {
    need(world != nullptr, HP_BAD_ARGUMENT, "hp_set_axes: the world is NULL");
    need(person >= 0 && person < hp_person_count(world), HP_NO_SUCH_NAME,
         "hp_set_axes: there is no such person");
    check_numbers(axes, 9, "hp_set_axes: axes");
    Mat3 a;
    std::copy_n(axes, 9, a.m);
    const Mat3 product = a * transposed(a);
    double off = 0;
    for (int i = 0; i < 9; i++) off = std::max(off, std::fabs(product.m[i] - (i % 4 == 0)));
    need(off < 1e-9 && dot(a.col(0), cross(a.col(1), a.col(2))) > 0, HP_BAD_ARGUMENT,
         "hp_set_axes: expected a rotation matrix (3 x 3)");
    PersonPlace& p = world->compiled->labels.people[person];
    p.axes = a, p.pelvis = a * p.rest_pelvis;
  });
}
