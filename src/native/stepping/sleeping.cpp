#include "stepping/sleeping.h"

#include "geometry/separation.h"
#include "stepping/free_motion.h"
#include "tuning.h"

namespace hp {

void wake_neighbours(System& system, Data& data, std::vector<char>& woken) {
  World& world = system.world;
  Poses& pose = data.state.pose;
  const double range = tuning::stepping::kWakeRange * world.settings.clearance;
  const int n = (int)world.shapes.size();
  for (bool more = true; more;) {
    more = false;
    for (int i = 0; i < n; i++)
      for (int j = 0; j < n && world.asleep[system.tree(i)]; j++) {
        if (!woken[system.tree(j)] ||
            world.pairing(world.shapes[i].name, world.shapes[j].name).ignore)
          continue;
        if (separate(world.place(pose, i), world.place(pose, j), range).dist >= range) continue;
        world.asleep[system.tree(i)] = 0;
        woken[system.tree(i)] = 1;
        more = true;
      }
  }
}

bool wake_touched(System& system, Data& data) {
  World& world = system.world;
  std::vector<char> woken(system.model.nbody, 0);
  bool any = false;
  auto wake = [&](int shape) {
    if (shape < 0 || !world.asleep[system.tree(shape)]) return;
    world.asleep[system.tree(shape)] = 0;
    woken[system.tree(shape)] = 1;
    any = true;
  };
  for (const std::vector<Contact>* contacts : {&data.attempt.contacts, &data.soft.rows()})
    for (const Contact& c : *contacts) {
      if (dot(c.impulse, c.n) <= 0) continue;
      wake(data.attempt.candidates[c.pair].shape);
      wake(data.attempt.candidates[c.pair].other_shape);
    }
  if (!any) return false;
  wake_neighbours(system, data, woken);
  object_velocity(system, data.state, data.step, data.step.length, &woken);
  return true;
}

void hold_asleep(const System& system, Step& step) {
  const World& world = system.world;
  for (int b : system.objects)
    if (world.asleep[b] && world.active[b])
      for (int i = system.model.dof_first[b]; i < system.model.dof_first[b] + 6; i++)
        step.v_free[i] = step.spin[i] = 0;
}

}  // namespace hp
