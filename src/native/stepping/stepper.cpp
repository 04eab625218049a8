#include "stepping/stepper.h"

#include <stdexcept>

#include "stepping/layer_load.h"
#include "tuning.h"

namespace hp {

void Stepper::start_asleep(int body) {
  if (body <= 0 || body >= system.model.nbody)
    throw std::invalid_argument("start_asleep: no such body");
  system.start_asleep.push_back(body);
}

void Stepper::finish(const std::vector<int>& person_roots) {
  system.finish(person_roots);
  data_.finish(system);
  data_.soft.finish(system);
  kinematic_.finish(system.model);
  prescribed_.finish(system.model);
  substep_.finish();
}

void Stepper::reset(const double* qpos, const double* qvel, bool stand) {
  State& state = data_.state;
  World& world = system.world;
  const Model& model = system.model;
  state.qpos.assign(qpos, qpos + model.nq);
  state.qvel.assign(qvel, qvel + model.nv);
  state.pose_known = false;
  state.update_pose(system);
  for (Drive& d : system.drives) {
    d.clock.reset(d, &state.qpos[d.first_qpos()]);
    d.reset(&state.qpos[d.first_qpos()], state.qvel.data());
  }
  data_.cache.clear();
  data_.soft.reset(model);
  data_.result.touches.clear();
  data_.result.soft.clear();
  probe.solve_times.clear();
  world.broad_phase.forget();
  world.asleep.assign(model.nbody, 0);  // what they rest on is known when they wake
  prescribed_.reset(system);
  world.reset(model, state.pose);
  if (stand) aiming_.start(system, state);
  for (int b : system.start_asleep) world.asleep[b] = 1;
  kinematic_.reset(model);
  state.exit_path.assign(model.nbody, 0);
  start_exits(system, state);
}

void Stepper::frame(const double* targets, double dt, int n, std::vector<double>* poses) {
  if (system.prescribed != Prescribed::No)
    return prescribed_.frame(system, data_, substep_, targets, dt, n, poses);
  State& state = data_.state;
  const bool pieces = probe.keep_pieces;
  const size_t recorded = poses ? poses->size() : 0;
  data_.budget.begin_frame(n, (int)system.drives.size());
  aiming_.begin(system, data_, targets, dt);
  paths_.begin(system, data_, dt, pieces);
  probe.pieces = pieces ? poses : nullptr;
  if (paths_.any_busy() && paths_.any_free())
    step_beside_free(dt, n, poses);
  else if (paths_.any_busy())
    substeps(dt, n, poses);
  else if (poses)
    for (int k = 0; k < n; k++) poses->insert(poses->end(), state.qpos.begin(), state.qpos.end());
  end_gentle_frame(system, state);
  paths_.arrive(system, data_, poses && !pieces ? poses->data() + recorded : nullptr, n);
  paths_.travel(system, data_);
  Aiming::end(system, data_.result);
  StandingLoad::end_frame(system, data_.result, dt);
  end_layer_frame(system, data_.result, dt);
}

// Steps busy trees, while free ones stand at the start of their paths. If busy trees get farther
// than was assumed, the frame is made again, with all trees stepped through.
void Stepper::step_beside_free(double dt, int n, std::vector<double>* poses) {
  const size_t recorded = poses ? poses->size() : 0;
  paths_.leave(data_.state);
  const std::vector<double> before = save();
  const std::vector<Drive> drives = system.drives;
  substeps(dt, n, poses);
  if (!paths_.strayed(system)) return;
  snapshot().load(before);
  system.drives = drives;
  if (poses) poses->resize(recorded);
  data_.result.clear(system.model.nbody);
  paths_.make_all_busy(system.model);
  data_.budget.begin_frame_again();
  substeps(dt, n, poses);
}

// Is what is left of the frame to be made in few steps? Soft layers need short ones.
bool Stepper::hurries() const { return data_.budget.frame_out() && !data_.soft.any(); }

// How many of the n substeps of length h, from number k on, are made as one: more only where the frame's
// budget has ended, so many that it begins at a multiple of its length, as the drive counts, and that
// nothing turns too far in it.
int Stepper::joined_substeps(int k, int n, double h) const {
  if (!hurries()) return 1;
  for (int joined = n - k; joined > 1; joined--)
    if (n % joined == 0 && k % joined == 0 && substep_.parts(joined * h) == 1) return joined;
  return 1;
}

void Stepper::substeps(double dt, int n, std::vector<double>* poses) {
  State& state = data_.state;
  const Model& model = system.model;
  const std::vector<char>& busy = paths_.busy();
  for (int b = 1; b < model.nbody; b++) system.world.active[b] = busy[model.root[b]];
  for (Drive& d : system.drives)
    if (busy[d.body(0)]) d.begin_frame(system.drive_settings, state.qpos.data(), state.qvel.data());
  for (int k = 0, joined; k < n; k += joined) {
    joined = joined_substeps(k, n, dt / n);
    const double h = joined * (dt / n);
    const int parts = substep_.parts(h);
    for (int i = 0, made = 1; i < parts; i += made) {
      // Parts cannot be joined: where the budget has ended one more is made of a substep.
      if (hurries()) made = parts - i;
      data_.budget.begin_substep((n - k) / joined * parts - i);
      data_.step.last = k + joined == n && i + made == parts;
      substep_.run(k / joined * parts + i, h / parts);
      if (made > 1) substep_.lose((made - 1) * (h / parts));
    }
    for (int i = 0; i < joined && poses && !probe.keep_pieces; i++)
      poses->insert(poses->end(), state.qpos.begin(), state.qpos.end());
  }
}

void Stepper::set_velocity(int body, const double* six) {
  const Model& model = system.model;
  if (body <= 0 || body >= model.nbody || model.dof_count[body] != 6)
    throw std::invalid_argument("set_velocity: no such body");
  qvel();
  std::copy_n(six, 6, &data_.state.qvel[model.dof_first[body]]);
  system.world.asleep[body] = 0;
}

const std::vector<double>& Stepper::qvel() {
  update_velocity(system, data_.state);
  return data_.state.qvel;
}

void Stepper::footing(std::vector<double>& out) const {
  for (const Drive& d : system.drives)
    out.insert(out.end(), {d.clock.lag(), d.footing.corrected() ? 1.0 : 0.0});
}

bool Stepper::torques(std::vector<double>& out) const {
  bool any = false;
  for (const Drive& d : system.drives) any |= d.effort.any();
  if (!any) return false;
  for (const Drive& d : system.drives) {
    const std::vector<double> force = d.effort.mean_force(d.motion.frame_length());
    for (int b = 0; b < d.ball_count(); b++)
      for (int c = 0; c < 3; c++)
        out.push_back(force.empty() ? 0.0 : force[d.ball_dof(b) - d.first_dof() + c]);
  }
  return true;
}

double Stepper::clearance() {
  data_.state.update_pose(system);
  const World& world = system.world;
  double smallest =
      smallest_clearance(world, world.broad_phase, data_.state.pose, system.clearance_range);
  // A part inside a mesh may be far from all of its triangles.
  for (const InitialOverlap& in : world.depenetration.overlaps())
    if (in.other_static >= 0 && world.shapes[in.shape].person >= 0)
      smallest = std::min(smallest, -in.depth());
  return smallest;
}

void Stepper::clearances(const double* qpos, size_t poses, double range, double* dist,
                         int* nearest) const {
  Poses p;  // of its own: the simulation does not change
  p.kin.resize(system.model);
  const size_t n = system.world.shapes.size();
  for (size_t t = 0; t < poses; t++) {
    p.kin.update(system.model, qpos + t * system.model.nq);
    system.world.start_poses(p);
    shape_clearances(system.world, p, range, dist + t * n, nearest + t * n);
  }
}

void Stepper::load(const std::vector<double>& state) {
  snapshot().check(state);
  snapshot().load(state);
  data_.result.touches.clear();
  data_.result.soft.clear();
  data_.result.points.clear();
  data_.result.diagnostics = {};
}

}  // namespace hp
