// Resets and frames, and states between them.
#include <cstring>

#include "assembly/system_calls.h"
#include "capi/world_handle.h"
#include "compiled/crc32.h"

using namespace hp;
using namespace hp::capi;

namespace {

constexpr double kLongestFrame = 10;  // [s]

// Before the numbers of a state.
struct StateHeader {
  char magic[8];
  uint32_t world;     // checksum of the world's file
  uint32_t checksum;  // of the numbers
  uint64_t count;
  double dt;
};
constexpr char kMagic[8] = {'H', 'P', 'S', 'T', 'A', 'T', 'E', '1'};

std::vector<double> own_stiffness(const Labels& labels) {
  std::vector<double> core;
  for (const PersonPlace& p : labels.people)
    for (int ball : p.ball) core.push_back(p.stiffness[ball]);
  return core;
}

void check(bool ok) {
  need(ok, HP_BAD_STATE,
       "hp_load: these bytes are no state of this world; expected what hp_save gave");
}

}  // namespace

hp_status hp_reset(hp_world* world, const double* translation, const double* rotations) {
  return guarded([&] {
    need(world != nullptr, HP_BAD_ARGUMENT, "hp_reset: the world is NULL");
    std::vector<double> qpos = world->labels().start_qpos;
    put_poses(*world, translation, rotations, qpos.data(), nullptr);
    world->stepper().reset(qpos.data(), world->labels().start_qvel.data());
    set_stiffness(world->stepper(), own_stiffness(world->labels()).data());
    world->started = true, world->dt = 0;
  });
}

hp_status hp_step(hp_world* world, const double* translation, const double* rotations, double dt) {
  return guarded([&] {
    hp_world& w = running(world, "hp_step");
    check_positive(dt, kLongestFrame, "hp_step: dt");
    std::vector<double> qpos(w.stepper().system.model.nq), targets;
    put_poses(w, translation, rotations, qpos.data(), &targets);
    w.stepper().frame(targets.data(), dt, w.labels().substeps_for(dt));
    w.dt = dt;
  });
}

hp_status hp_save(hp_world* world, void* out, size_t room, size_t* size) {
  return guarded([&] {
    hp_world& w = running(world, "hp_save");
    need(size != nullptr, HP_BAD_ARGUMENT, "hp_save: size is NULL");
    const std::vector<double> numbers = w.stepper().save();
    const size_t bytes = numbers.size() * sizeof(double);
    *size = sizeof(StateHeader) + bytes;
    if (!out) return;
    need(room >= *size, HP_BAD_ARGUMENT, "hp_save: there is too little room for the state");
    StateHeader header{};
    std::memcpy(header.magic, kMagic, sizeof kMagic);
    header.world = w.compiled->checksum, header.count = numbers.size(), header.dt = w.dt;
    header.checksum = crc32(reinterpret_cast<const unsigned char*>(numbers.data()), bytes);
    std::memcpy(out, &header, sizeof header);
    std::memcpy(static_cast<char*>(out) + sizeof header, numbers.data(), bytes);
  });
}

hp_status hp_load(hp_world* world, const void* state, size_t size) {
  return guarded(
      [&] {
        need(world != nullptr && state != nullptr, HP_BAD_ARGUMENT,
             "hp_load: the world or the state is NULL");
        StateHeader header;
        check(size >= sizeof header);
        std::memcpy(&header, state, sizeof header);
        check(std::memcmp(header.magic, kMagic, sizeof kMagic) == 0 &&
              header.world == world->compiled->checksum &&
              header.count == (size - sizeof header) / sizeof(double) &&
              (size - sizeof header) % sizeof(double) == 0);
        std::vector<double> numbers(header.count);
        const auto* bytes = static_cast<const unsigned char*>(state) + sizeof header;
        check(crc32(bytes, size - sizeof header) == header.checksum);
        std::memcpy(numbers.data(), bytes, size - sizeof header);
        world->stepper().load(numbers);
        world->started = true, world->dt = header.dt;
      },
      HP_BAD_STATE);
}
