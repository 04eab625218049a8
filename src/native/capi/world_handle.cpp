#include "capi/world_handle.h"

#include <cmath>

namespace hp::capi {

namespace {

constexpr double kLargest = 1e6;  // no translation [m], rotation [rad] or impulse is larger

}  // namespace

hp_world& running(hp_world* world, const char* function) {
  need(world != nullptr, HP_BAD_ARGUMENT, std::string(function) + ": the world is NULL");
  need(world->started, HP_NOT_STARTED,
       std::string(function) + ": the world has no pose yet; call hp_reset first");
  return *world;
}

void check_numbers(const double* values, size_t count, const char* name) {
  need(values != nullptr || count == 0, HP_BAD_ARGUMENT, std::string(name) + " is NULL");
  for (size_t i = 0; i < count; i++)
    need(std::fabs(values[i]) <= kLargest, HP_BAD_ARGUMENT,
         std::string(name) + ": found " + std::to_string(values[i]) + " at index " +
             std::to_string(i) + ", expected a finite number of at most 1e6");
}

void check_positive(double value, double most, const char* name) {
  need(value > 0 && value <= most, HP_BAD_ARGUMENT,
       std::string(name) + ": found " + std::to_string(value) +
           ", expected a number over 0, up to " + std::to_string(most));
}

ObjectPlace* object(hp_world& world, const char* name, const char* function) {
  need(name != nullptr, HP_BAD_ARGUMENT, std::string(function) + ": the name is NULL");
  for (ObjectPlace& o : world.compiled->labels.objects)
    if (o.name == name) return &o;
  std::string there;
  for (const ObjectPlace& o : world.labels().objects) there += (there.empty() ? "" : ", ") + o.name;
  need(world.labels().find(name) >= 0, HP_NO_SUCH_NAME,
       std::string(function) + ": there is nothing called '" + name +
           "'; objects: " + (there.empty() ? "none" : there));
  return nullptr;
}

ObjectPlace& free_object(hp_world& world, const char* name, const char* function) {
  ObjectPlace* found = object(world, name, function);
  need(found != nullptr && found->pushable, HP_NO_SUCH_NAME,
       std::string(function) + ": '" + name +
           "' does not move freely; expected an object that is neither held nor on a trajectory");
  return *found;
}

void put_poses(const hp_world& world, const double* translation, const double* rotations,
               double* qpos, std::vector<double>* targets) {
  const size_t people = world.labels().people.size();
  check_numbers(translation, 3 * people, "translation");
  check_numbers(rotations, 3 * kJoints * people, "rotations");
  for (const PersonPlace& p : world.labels().people) {
    store3(qpos + p.qpos, load3(translation) + p.pelvis);
    for (int j = 0; j < kJoints; j++)
      store4(qpos + p.joint_qpos[j], exp_quat(load3(rotations + 3 * j)));
    if (targets)
      targets->insert(targets->end(), qpos + p.qpos, qpos + p.qpos + 7 + 4 * (kJoints - 1));
    translation += 3, rotations += 3 * kJoints;
  }
}

}  // namespace hp::capi
