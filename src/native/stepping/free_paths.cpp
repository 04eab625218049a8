#include "stepping/free_paths.h"

#include "tuning.h"

namespace hp {

namespace tune = tuning::stepping;

void FreePaths::begin(System& system, Data& data, double dt, bool all_busy) {
  settled_.clear();
  for (const Drive& d : system.drives)
    settled_.push_back(d.settled(system.drive_settings, data.state.qpos.data()));
  start_qpos_ = data.state.qpos;
  if (all_busy)
    busy_.assign(system.model.nbody, 1);
  else
    find(system, data, dt);
  count(system.model);
}

void FreePaths::count(const Model& m) {
  any_busy_ = any_free_ = false;
  for (int b = 1; b < m.nbody; b++)
    if (m.root[b] == b) (busy_[b] ? any_busy_ : any_free_) = true;
}

void FreePaths::make_all_busy(const Model& m) {
  busy_.assign(m.nbody, 1);
  any_free_ = false;
}

void FreePaths::find(System& system, Data& data, double dt) {
  const Model& model = system.model;
  World& world = system.world;
  Poses &start = data.state.pose, &end = data.step.end;
  busy_.assign(model.nbody, 1);
  end_qpos_ = data.state.qpos;
  bool any = false;
  for (size_t p = 0; p < system.drives.size(); p++) {
    const Drive& d = system.drives[p];
    if (system.carries(d) || !settled_[p]) continue;
    busy_[d.body(0)] = 0;
    d.motion.follow(1, end_qpos_.data());
    any = true;
  }
  if (!any) return;
  follows_.assign(model.nbody, 0);
  for (int b = 1; b < model.nbody; b++) follows_[b] = !busy_[model.root[b]];
  world.active = follows_;
  end.kin.update(model, end_qpos_.data(), world.active.data());
  world.start_poses(end);
  between_known_ = false;
  sweep_.between = [this, &system]() -> std::vector<Poses>& { return between(system); };
  const size_t n = world.shapes.size();
  sweep_.travel.assign(n, 0);
  sweep_.bulge.assign(n, 0);
  assume_strays(system, data, dt);
  travel_bounds(world.shapes, start, end, world.active, sweep_.straight);
  world.inner_travel(model, start, end, sweep_.inner);
  for (const Drive& d : system.drives) sweep(system, d, dt);
  world.active.assign(model.nbody, 1);
  world.broad_phase.update(model, start, sweep_.travel, world.depenetration.overlaps());
  mark_busy_trees(world, world.broad_phase, world.depenetration.overlaps(), model, start, end,
                  sweep_, busy_);
  if (data.soft.any()) data.soft.mark_busy(system, data, sweep_.travel, busy_);
}

std::vector<Poses>& FreePaths::between(const System& system) {
  if (between_known_) return between_;
  between_known_ = true;
  between_.resize(tuning::collision::kPathParts - 1);
  for (size_t k = 0; k < between_.size(); k++) {
    part_qpos_ = start_qpos_;
    for (const Drive& d : system.drives)
      if (follows_[d.body(0)])
        d.motion.follow((k + 1.0) / tuning::collision::kPathParts, part_qpos_.data());
    between_[k].kin.resize(system.model);
    between_[k].kin.update(system.model, part_qpos_.data(), follows_.data());
    system.world.start_poses(between_[k]);
  }
  return between_;
}

// Busy trees are assumed not to get much farther than they would by themselves.
void FreePaths::assume_strays(System& system, Data& data, double dt) {
  const World& world = system.world;
  State& state = data.state;
  const size_t n = world.shapes.size();
  assumed_.assign(n, 0);
  bool found = false;
  for (size_t i = 0; i < n; i++) {
    if (!busy_[system.tree((int)i)]) continue;
    if (!found) {
      state.pose.kin.update_dofs(system.model, state.qpos.data());
      for (Drive& d : system.drives) d.motion.velocity(state.qvel.data());
      body_twists(system.model, state.pose.kin, state.qvel.data(), twists_);
      found = true;
    }
    const double fall = norm(system.gravity) * dt * dt;
    const double speed = system.speed_bound(state.pose.kin, world.shapes[i], twists_);
    sweep_.travel[i] = 1.5 * dt * speed + fall + tune::kFrameStray;
    assumed_[i] = world.broad_phase.travelled((int)i) + sweep_.travel[i];
  }
}

// W, B and A of a person's bodies.
void FreePaths::bound_speeds(const Model& m, const Drive& d) {
  d.motion.speeds(angular_);
  spin_.resize(m.nbody);
  turn_.resize(m.nbody);
  acceleration_.resize(m.nbody);
  rate_.resize(m.nbody);
  for (size_t i = 0; i < angular_.size(); i++) {
    const int b = d.body((int)i), p = m.parent[b];
    const double w = angular_[i];
    if (i == 0) {
      spin_[b] = w, turn_[b] = 0, acceleration_[b] = 0, rate_[b] = w * w;
      continue;
    }
    spin_[b] = spin_[p] + w;
    turn_[b] = turn_[p] + spin_[p] * w;
    acceleration_[b] = acceleration_[p] + rate_[p] * norm(m.pos[b]);
    rate_[b] = spin_[b] * spin_[b] + turn_[b];
  }
}

// Upper bound of the acceleration of all points of a shape [m/s^2].
double FreePaths::bulge(const Model& m, const CollisionShape& shape) const {
  double bulge = shape.weighted_bound([&](const CollisionShape::Influence& t) {
    const int b = t.body;
    return acceleration_[b] + rate_[b] * t.far;
  });
  if (shape.blend_bounds.empty()) return bulge;
  // Blend shapes move the points in frames that turn.
  double speed = 0, rate = 0, spin = 0;
  for (const CollisionShape::BlendBound& s : shape.blend_bounds) {
    const int b = shape.skin->body[s.joint];
    const double w = spin_[b] - spin_[m.parent[b]];
    speed += std::sqrt(2.0) * s.gain * w, rate += std::sqrt(2.0) * s.gain * w * w;
  }
  for (const CollisionShape::Influence& t : shape.influences) spin = std::max(spin, spin_[t.body]);
  bulge += rate + 2 * spin * speed;
  return bulge;
}

void FreePaths::sweep(const System& system, const Drive& d, double dt) {
  const Model& model = system.model;
  if (busy_[d.body(0)]) return;
  bound_speeds(model, d);
  const int root = model.root[d.body(0)];
  const double share = 0.125 * dt * dt;
  for (size_t i = 0; i < system.world.shapes.size(); i++) {
    const CollisionShape& m = system.world.shapes[i];
    if (model.root[m.body] != root) continue;
    sweep_.bulge[i] = share * bulge(model, m);
    sweep_.travel[i] = sweep_.straight[i] + sweep_.bulge[i];
  }
}

bool FreePaths::strayed(const System& system) {
  bool strayed = false;
  for (size_t i = 0; i < system.world.shapes.size(); i++)
    strayed |=
        busy_[system.tree((int)i)] && system.world.broad_phase.travelled((int)i) > assumed_[i];
  return strayed;
}

bool FreePaths::beyond(const System& system, const std::vector<double>& way) const {
  for (size_t i = 0; i < system.world.shapes.size(); i++)
    if (busy_[system.tree((int)i)] &&
        system.world.broad_phase.travelled((int)i) + way[i] > assumed_[i])
      return true;
  return false;
}

void FreePaths::along(const Drive& d, double share, double* q) const {
  std::copy_n(&start_qpos_[d.first_qpos()], d.qpos_count(), q + d.first_qpos());
  d.motion.follow(share, q);
}

void FreePaths::arrive(System& system, Data& data, double* rows, int n) {
  State& state = data.state;
  for (size_t i = 0; i < system.drives.size(); i++) {
    Drive& d = system.drives[i];
    if (!settled_[i] || data.result.disturbed[d.body(0)]) continue;
    for (int k = 0; k < n && rows; k++) along(d, (k + 1.0) / n, rows + (size_t)k * system.model.nq);
    along(d, 1, state.qpos.data());
    d.followed(system.carries(d));
    if (busy_[d.body(0)]) state.pose_known = false;  // the last step ended a rounding away
  }
}

void FreePaths::travel(System& system, Data& data) {
  if (!any_free_) return;
  const Model& model = system.model;
  World& world = system.world;
  Poses& end = data.step.end;
  if (any_busy_) {
    for (int b = 1; b < model.nbody; b++) world.active[b] = !busy_[model.root[b]];
    end.kin.update(model, data.state.qpos.data());
    world.start_poses(end);
    travel_bounds(world.shapes, followed_, end, world.active, way_);
    world.inner_travel(model, followed_, end, sweep_.inner);
  }
  const std::vector<double>& way = any_busy_ ? way_ : sweep_.straight;
  world.end_check.find(any_busy_ ? followed_ : data.state.pose, end, way, sweep_.inner);
  world.broad_phase.travel(way, sweep_.inner);
  for (const Breach& k : world.end_check.commit(end)) data.result.add(k);
  std::swap(data.state.pose, end);
  world.active.assign(model.nbody, 1);
}

}  // namespace hp
