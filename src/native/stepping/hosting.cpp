#include "stepping/hosting.h"

#include <algorithm>
#include <cmath>

#include "stepping/exit_motion.h"
#include "tuning.h"

namespace hp {

void Hosting::start(System& system, Data& data, Host& host) {
  forces_.remove(host);
  data.result.points.clear();
  show(system, data, host);
}

void Hosting::show(System& system, Data& data, Host& host) {
  data.state.update_pose(system);
  host.show(data.state.pose.kin);
}

void Hosting::begin(System& system, Data& data, Aiming& aiming, Host& host, const double* targets,
                    int n, double h, bool watched) {
  host_ = &host, n_ = n, h_ = h, watched_ = watched;
  data.result.keep_points = true;
  forces_.remove(host);
  take(system, data.state);
  aiming.begin(system, data, targets, n * h);
  paths_.begin(system, data, n * h, data.probe.keep_pieces);
  free_ = true;
  // Who stands on the host's things holds them, in substeps.
  for (const Drive& d : system.drives)
    free_ &= !paths_.busy()[d.body(0)] && !(d.footing.on() && d.footing.bearing.any());
  system.world.active.assign(system.model.nbody, 1);
  if (free_) return;
  paths_.make_all_busy(system.model);
  for (Drive& d : system.drives)
    d.begin_frame(system.drive_settings, data.state.qpos.data(), data.state.qvel.data());
}

// Differences up to kPlacedByHost are rounding between two engines' integration; a body that is
// farther from where it was left has been put there.
Hosting::Change Hosting::take_pose(const System& system, State& state) const {
  const Model& model = system.model;
  const double* qpos = host_->qpos;
  Change change = Change::None;
  for (int j = 0; j < model.njnt; j++) {
    if (!host_->owns(model.jnt_body[j])) continue;
    const int first = model.jnt_qpos[j], count = qpos_width(model.jnt_type[j]);
    for (int i = first; i < first + count; i++) {
      if (qpos[i] != state.qpos[i] && change == Change::None) change = Change::Rounding;
      if (std::fabs(qpos[i] - state.qpos[i]) > tuning::stepping::kPlacedByHost)
        change = Change::Placed;
      state.qpos[i] = qpos[i];
    }
  }
  return change;
}

void Hosting::take(System& system, State& state) {
  const Change change = take_pose(system, state);
  std::copy_n(host_->qvel, host_->nv, state.qvel.begin());
  if (change != Change::None) state.pose_known = false;
  state.update_pose(system);
  if (change == Change::Placed) system.world.broad_phase.forget();
}

void Hosting::show_path(const System& system, double share) {
  path_ = paths_.start();
  for (const Drive& d : system.drives) paths_.along(d, share, path_.data());
  hosted_.assign(system.model.nbody, 0);
  for (const Drive& d : system.drives)
    for (int i = 0; i < d.ball_count(); i++) hosted_[d.body(i)] = 1;
  now_.kin.resize(system.model);
  now_.kin.update(system.model, path_.data(), hosted_.data());
  host_->show(now_.kin);
}

void Hosting::before(System& system, Data& data, int k) {
  if (free_) {
    if (k > 0 && (watched_ || k == n_ - 1)) show_path(system, (double)k / n_);
  } else {
    if (k > 0) take(system, data.state);
    host_->show(data.state.pose.kin);
  }
  qpos_.assign(host_->qpos, host_->qpos + host_->nq);
  qvel_.assign(host_->qvel, host_->qvel + host_->nv);
  data.result.points.clear();
  pressing_.clear();
  StandingLoad::pressing(system, h_, pressing_);
  if (!pressing_.empty()) press(system, data.state);
}

// Weights of people, about centres of mass where the host's bodies are now: its own are those of the
// timestep before, or of wherever they were before somebody put them here.
void Hosting::press(const System& system, const State& state) {
  pose_bodies(system, state);
  for (const StandingLoad::Pressing& p : pressing_) {
    const int b = system.world.shapes[p.shape].body;
    const Vec3 centre = now_.kin.xpos[b] + now_.kin.xmat[b] * system.model.ipos[b];
    forces_.add(*host_, host_->number(b), centre, p.at, p.force);
  }
}

void Hosting::after(System& system, Data& data, Substep& substep, int k) {
  forces_.remove(*host_);
  if (free_ && stay_clear(system, data.state)) return;
  if (free_) leave_paths(system, data, k);
  make_substep(system, data, substep, k);
  give_back(system, data);
}

// The host's bodies where it has them now.
void Hosting::pose_bodies(const System& system, const State& state) {
  const Model& model = system.model;
  hosted_.assign(model.nbody, 0);
  for (int b = 1; host_->owns(b); b++) hosted_[b] = 1;
  path_ = state.qpos;
  std::copy_n(host_->qpos, host_->nq, path_.begin());
  now_.kin.resize(model);
  now_.kin.update(model, path_.data(), hosted_.data());
}

// The host's bodies went no farther since the frame began than free paths assume.
bool Hosting::stay_clear(System& system, const State& state) {
  pose_bodies(system, state);
  travel_bounds(system.world.shapes, state.pose, now_, hosted_, way_);
  return !paths_.beyond(system, way_);
}

// People leave their paths at the start of timestep k, and the host's bodies are where they were then.
void Hosting::leave_paths(System& system, Data& data, int k) {
  State& state = data.state;
  free_ = false;
  for (Drive& d : system.drives)
    d.begin_frame(system.drive_settings, paths_.start().data(), state.qvel.data());
  for (const Drive& d : system.drives) paths_.along(d, (double)k / n_, state.qpos.data());
  paths_.make_all_busy(system.model);
  std::copy(qpos_.begin(), qpos_.end(), state.qpos.begin());
  std::copy(qvel_.begin(), qvel_.end(), state.qvel.begin());
  move_all(system, data);
}

// From the pose of the state to that of its qpos, all trees together.
void Hosting::move_all(System& system, Data& data) {
  State& state = data.state;
  World& world = system.world;
  Poses& end = data.step.end;
  world.active.assign(system.model.nbody, 1);
  end.kin.update(system.model, state.qpos.data());
  world.start_poses(end);
  travel_bounds(world.shapes, state.pose, end, world.active, way_);
  world.inner_travel(system.model, state.pose, end, inner_);
  world.end_check.find(state.pose, end, way_, inner_);
  world.broad_phase.travel(way_, inner_);
  for (const Breach& k : world.end_check.commit(end)) data.result.add(k);
  std::swap(state.pose, end);
  state.pose_known = true;
}

void Hosting::make_substep(System& system, Data& data, Substep& substep, int k) {
  const Model& model = system.model;
  std::vector<double>& damping = data.step.resistance.damping;
  damping.assign(model.nv, 0);
  std::copy_n(host_->damping, host_->nv, damping.begin());
  v_free_.assign(model.nv, 0);
  std::copy_n(host_->qvel, host_->nv, v_free_.begin());
  for (int b = 1; host_->owns(b); b++) data.result.disturbed[b] = 0;
  data.step.host_v_free = v_free_.data();
  data.budget.begin_frame(1, (int)system.drives.size());
  data.budget.begin_substep(1);
  substep.run(k, h_);
  data.step.host_v_free = nullptr;
}

// Bodies that people touched; all others keep the host's own step bit for bit.
void Hosting::give_back(const System& system, const Data& data) {
  const Model& model = system.model;
  const State& state = data.state;
  auto touched = [&](int body) {
    return host_->owns(body) && data.result.disturbed[model.root[body]];
  };
  for (int j = 0; j < model.njnt; j++)
    if (touched(model.jnt_body[j]))
      std::copy_n(&state.qpos[model.jnt_qpos[j]], qpos_width(model.jnt_type[j]),
                  host_->qpos + model.jnt_qpos[j]);
  for (int i = 0; i < host_->nv; i++) {
    if (!touched(model.dof_body[i])) continue;
    host_->qacc[i] += (state.qvel[i] - v_free_[i]) / h_;
    host_->qvel[i] = state.qvel[i];
  }
}

void Hosting::end(System& system, Data& data) {
  State& state = data.state;
  end_gentle_frame(system, state);
  paths_.arrive(system, data, nullptr, n_);
  if (free_) {
    std::copy_n(host_->qpos, host_->nq, state.qpos.begin());
    std::copy_n(host_->qvel, host_->nv, state.qvel.begin());
    move_all(system, data);
  }
  Aiming::end(system, data.result);
  StandingLoad::end_frame(system, data.result, n_ * h_);
  state.update_pose(system);
  host_->show(state.pose.kin);
  for (const StandingLoad::Pressing& p : pressing_)
    data.result.points.push_back({p.person, -1, p.shape, p.at, {0, 0, 1}, -h_ * p.force, 0});
  auto push = [&](int shape, Vec3 at, Vec3 force) {
    const int body = shape < 0 ? 0 : system.world.shapes[shape].body;
    if (!host_->owns(body)) return;
    const int b = host_->number(body);
    forces_.add(*host_, b, load3(host_->xipos + 3 * b), at, force);
  };
  for (const FrameResult::Point& p : data.result.points) {
    push(p.shape, p.position, (1 / h_) * p.impulse);
    push(p.other_shape, p.position, (-1 / h_) * p.impulse);
  }
}

}  // namespace hp
