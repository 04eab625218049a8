// The library as such, and worlds: made, freed, what is in them.
#include <cerrno>
#include <cstdio>
#include <cstring>

#include "capi/world_handle.h"
#include "compiled/replay.h"
#include "compiled/world_file.h"

using namespace hp;
using namespace hp::capi;

namespace {

constexpr const char* kJointNames[HP_JOINTS] = {"pelvis",
                                                "left_hip",
                                                "right_hip",
                                                "spine1",
                                                "left_knee",
                                                "right_knee",
                                                "spine2",
                                                "left_ankle",
                                                "right_ankle",
                                                "spine3",
                                                "left_foot",
                                                "right_foot",
                                                "neck",
                                                "left_collar",
                                                "right_collar",
                                                "head",
                                                "left_shoulder",
                                                "right_shoulder",
                                                "left_elbow",
                                                "right_elbow",
                                                "left_wrist",
                                                "right_wrist",
                                                "jaw",
                                                "left_eye_smplhf",
                                                "right_eye_smplhf",
                                                "left_index1",
                                                "left_index2",
                                                "left_index3",
                                                "left_middle1",
                                                "left_middle2",
                                                "left_middle3",
                                                "left_pinky1",
                                                "left_pinky2",
                                                "left_pinky3",
                                                "left_ring1",
                                                "left_ring2",
                                                "left_ring3",
                                                "left_thumb1",
                                                "left_thumb2",
                                                "left_thumb3",
                                                "right_index1",
                                                "right_index2",
                                                "right_index3",
                                                "right_middle1",
                                                "right_middle2",
                                                "right_middle3",
                                                "right_pinky1",
                                                "right_pinky2",
                                                "right_pinky3",
                                                "right_ring1",
                                                "right_ring2",
                                                "right_ring3",
                                                "right_thumb1",
                                                "right_thumb2",
                                                "right_thumb3"};

thread_local char last_error[1024] = "";

#ifndef __EMSCRIPTEN__  // there are no files in a browser
std::vector<unsigned char> content(const char* path) {
  need(path != nullptr, HP_BAD_ARGUMENT, "hp_world_open: the path is NULL");
  std::unique_ptr<std::FILE, int (*)(std::FILE*)> file(std::fopen(path, "rb"), &std::fclose);
  need(file != nullptr, HP_BAD_FILE, std::string(path) + ": cannot read it: " + strerror(errno));
  std::vector<unsigned char> bytes;
  unsigned char block[1 << 16];
  size_t n = sizeof block;
  while (n == sizeof block) {
    n = std::fread(block, 1, sizeof block, file.get());
    bytes.insert(bytes.end(), block, block + n);
  }
  need(!std::ferror(file.get()), HP_BAD_FILE, std::string(path) + ": cannot read it to its end");
  return bytes;
}
#endif

std::unique_ptr<hp_world> made(const void* bytes, size_t size) {
  auto world = std::make_unique<hp_world>();
  world->compiled = read_world(bytes, size);
  const Labels& labels = world->labels();
  for (const PersonPlace& p : labels.people)
    for (const char* joint : kJointNames) world->body_names.push_back(p.name + "/" + joint);
  for (const ObjectPlace& o : labels.objects) world->body_names.push_back(o.name);
  for (const LinkPlace& l : labels.links) world->body_names.push_back(l.name);
  return world;
}

const char* at(const std::vector<std::string>& names, int index) {
  return index >= 0 && (size_t)index < names.size() ? names[index].c_str() : nullptr;
}

}  // namespace

hp_status hp::capi::failed(hp_status status, const char* what) noexcept {
  std::snprintf(last_error, sizeof last_error, "%s", what);
  return status;
}

const char* hp_version(void) { return HALFPHYSICS_VERSION; }

int hp_world_file_version(void) { return (int)kWorldFileVersion; }

const char* hp_error(void) { return last_error; }

const char* hp_joint_name(int joint) {
  return joint >= 0 && joint < HP_JOINTS ? kJointNames[joint] : nullptr;
}

hp_world* hp_world_load(const void* bytes, size_t size) {
  std::unique_ptr<hp_world> world;
  guarded(
      [&] {
        need(bytes != nullptr, HP_BAD_ARGUMENT, "hp_world_load: the bytes are NULL");
        world = made(bytes, size);
      },
      HP_BAD_FILE);
  return world.release();
}

#ifndef __EMSCRIPTEN__
hp_world* hp_world_open(const char* path) {
  std::unique_ptr<hp_world> world;
  guarded(
      [&] {
        const std::vector<unsigned char> bytes = content(path);
        world = made(bytes.data(), bytes.size());
      },
      HP_BAD_FILE);
  return world.release();
}
#endif

void hp_world_free(hp_world* world) { delete world; }

int hp_person_count(const hp_world* world) {
  return world ? (int)world->labels().people.size() : 0;
}

int hp_name_count(const hp_world* world) {
  return world ? (int)world->labels().everything.size() : 0;
}

const char* hp_name(const hp_world* world, int index) {
  return world ? at(world->labels().everything, index) : nullptr;
}

int hp_find(const hp_world* world, const char* name) {
  return world && name ? world->labels().find(name) : -1;
}

int hp_kind_of(const hp_world* world, int index) {
  if (!world || !at(world->labels().everything, index)) return -1;
  const Labels& labels = world->labels();
  if (index >= labels.first_person()) return HP_PERSON;
  for (const ObjectPlace& o : labels.objects)
    if (o.name == labels.everything[index]) return HP_OBJECT;
  for (const LinkPlace& l : labels.links)
    if (l.name == labels.everything[index]) return HP_LINK;
  return HP_STATIC;
}

int hp_body_count(const hp_world* world) { return world ? (int)world->body_names.size() : 0; }

const char* hp_body_name(const hp_world* world, int body) {
  return world ? at(world->body_names, body) : nullptr;
}

int hp_joint_count(const hp_world* world) { return world ? (int)world->labels().joints.size() : 0; }

const char* hp_hinge_name(const hp_world* world, int joint) {
  if (!world || joint < 0 || (size_t)joint >= world->labels().joints.size()) return nullptr;
  return world->labels().joints[joint].name.c_str();
}
