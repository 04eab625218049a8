#include "stepping/snapshot.h"

#include <algorithm>
#include <stdexcept>

#include "stepping/exit_motion.h"
#include "tuning.h"

namespace hp {

void update_velocity(const System& system, State& state) {
  for (const Drive& d : system.drives) d.motion.velocity(state.qvel.data());
}

std::vector<double> Snapshot::parts() const {
  const Model& model = system.model;
  const World& world = system.world;
  return {(double)model.nq,
          (double)model.nv,
          (double)model.nbody,
          (double)system.drives.size(),
          (double)world.shapes.size(),
          (double)world.statics.size(),
          world.self_contact() ? 1.0 : 0.0,
          (double)data.soft.pairs(),
          (double)system.prescribed};
}

std::vector<double> Snapshot::save() {
  State& state = data.state;
  const World& world = system.world;
  update_velocity(system, state);
  std::vector<double> out = parts();
  out.insert(out.end(), state.qpos.begin(), state.qpos.end());
  out.insert(out.end(), state.qvel.begin(), state.qvel.end());
  for (const Drive& d : system.drives) d.save(out);
  world.save(out);
  out.insert(out.end(), state.exit_path.begin(), state.exit_path.end());
  out.insert(out.end(), world.asleep.begin(), world.asleep.end());
  kinematic.save(out);
  if (system.prescribed != Prescribed::No) prescribed.save(world, out);
  if (data.soft.any()) data.soft.save(out);
  data.cache.save(out);
  out.push_back((double)out.size());
  return out;
}

void Snapshot::check(const std::vector<double>& state) const {
  if (state.size() < 2 || state.back() != (double)(state.size() - 1))
    throw std::invalid_argument("the state is not whole");
  const std::vector<double> own = parts();
  if (state.size() <= own.size() || !std::equal(own.begin(), own.end(), state.begin()))
    throw std::invalid_argument(
        "the state is of people or items of other numbers, or of other contact settings");
}

void Snapshot::load(const std::vector<double>& numbers) {
  State& state = data.state;
  World& world = system.world;
  const Model& model = system.model;
  state.pose_known = false;
  const double* in = numbers.data() + parts().size();
  std::copy(in, in + model.nq, state.qpos.begin());
  in += model.nq;
  std::copy(in, in + model.nv, state.qvel.begin());
  in += model.nv;
  for (Drive& d : system.drives) in = d.load(in);
  in = world.load(in);
  state.exit_path.assign(in, in + model.nbody);
  in += model.nbody;
  world.asleep.assign(in, in + model.nbody);
  in += model.nbody;
  in = kinematic.load(in);
  if (system.prescribed != Prescribed::No) in = prescribed.load(world, in);
  for (Drive& d : system.drives)
    if (d.gentle()) d.gentle_return.start(d, tuning::stepping::kReturnSpeed, system.joint_reach);
  if (data.soft.any()) in = data.soft.load(in);
  data.cache.load(in);
  state.update_pose(system);
}

void Snapshot::adopt_bodies(const Snapshot& old, const std::vector<int>& body) {
  const Model& model = system.model;
  for (int b = 1; b < model.nbody; b++) {
    const int was = body[b];
    if (was < 0) continue;
    std::copy_n(&old.data.state.qvel[old.system.model.dof_first[was]], model.dof_count[b],
                &data.state.qvel[model.dof_first[b]]);
    system.world.asleep[b] = old.system.world.asleep[was];
    data.state.exit_path[b] = old.data.state.exit_path[was];
  }
}

void Snapshot::adopt_drives(const Snapshot& old) {
  for (size_t p = 0; p < system.drives.size(); p++) {
    Drive& d = system.drives[p];
    std::vector<double> state;
    old.system.drives[p].save(state);
    d.load(state.data());
    if (d.gentle()) d.gentle_return.start(d, tuning::stepping::kReturnSpeed, system.joint_reach);
  }
}

void Snapshot::adopt(const Snapshot& old, const std::vector<int>& body,
                     const std::vector<int>& shape) {
  if ((int)body.size() != system.model.nbody || shape.size() != system.world.shapes.size() ||
      system.drives.size() != old.system.drives.size())
    throw std::invalid_argument("adopt: not the same people");
  update_velocity(old.system, old.data.state);
  adopt_bodies(old, body);
  adopt_drives(old);
  kinematic.adopt(old.kinematic, body);
  system.world.adopt(old.system.world, shape);
  // A new object may be inside a person.
  start_exits(system, data.state);
  std::vector<int> now(old.system.world.shapes.size(), -1);
  for (int i = 0; i < (int)shape.size(); i++)
    if (shape[i] >= 0) now[shape[i]] = i;
  data.cache.adopt(old.data.cache, now);
  data.soft.adopt(old.data.soft, body, now);
}

}  // namespace hp
