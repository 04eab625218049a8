#include "stepping/baselines/prescribed_poses.h"

#include "stepping/substep.h"
#include "tuning.h"

namespace hp {

namespace tune = tuning::stepping;

void PrescribedPoses::reset(System& system) {
  const int nbody = system.model.nbody;
  system.world.prescribed_exits.pace.assign(nbody, 1);
  system.world.prescribed_exits.squeezed.assign(nbody, 0);
  push_.assign(nbody, {});
  if (system.prescribed != Prescribed::No) stand_aside(system);
}

// All trees but people are active; people are obstacles or, in "kinematic", not there.
void PrescribedPoses::stand_aside(System& system) const {
  Model& model = system.model;
  for (int b = 1; b < model.nbody; b++) {
    const bool person = system.is_person(b);
    system.world.active[b] = !person;
    system.world.standing[b] = person && system.prescribed != Prescribed::Kinematic;
    if (person) model.held[b] = 1;
  }
}

// Puts all people at a share of the frame's path.
void PrescribedPoses::put_people(System& system, Data& data, double share) {
  World& world = system.world;
  State& state = data.state;
  Poses& end = data.step.end;
  for (const Drive& d : system.drives) d.motion.put(share, state.qpos.data());
  end.kin.update(system.model, state.qpos.data());
  world.start_poses(end);
  for (int b = 1; b < system.model.nbody; b++) world.active[b] = system.is_person(b);
  travel_bounds(world.shapes, state.pose, end, world.active, way_);
  world.broad_phase.travel(way_, {});
  world.prescribed_exits.forget();
  // A step moves active trees from one pose to the other: all others are in both.
  state.pose.kin = end.kin;
  world.start_poses(state.pose);
  stand_aside(system);
}

void PrescribedPoses::frame(System& system, Data& data, Substep& substep, const double* targets,
                            double dt, int n, std::vector<double>* poses) {
  State& state = data.state;
  data.result.clear(system.model.nbody);
  state.update_pose(system);
  for (Drive& d : system.drives) {
    d.aim(system.drive_settings, targets, dt, state.qpos.data());
    targets += d.qpos_count();
    std::fill_n(state.qvel.begin() + d.first_dof(), d.dof_count(), 0.0);
  }
  data.probe.pieces = nullptr;
  bool objects = false;
  for (int b = 1; b < system.model.nbody; b++) objects |= !system.is_person(b);
  data.budget.begin_frame(n, (int)system.drives.size());
  for (int k = 0; k < n; k++) {
    if (system.prescribed == Prescribed::Interpolated)
      put_people(system, data, (k + 1.0) / n);
    else if (k == 0)
      put_people(system, data, 1);
    const int parts = substep.parts(dt / n);
    for (int i = 0; i < parts && objects; i++) {
      gain_pace(system.world, dt / n / parts);
      data.budget.begin_substep((n - k) * parts - i);
      substep.run(k * parts + i, dt / n / parts);
    }
    if (poses) poses->insert(poses->end(), state.qpos.begin(), state.qpos.end());
  }
  system.world.active.assign(system.model.nbody, 1);
}

// Objects without room are not pushed for a while; those that were pushed more gently gain speed.
void PrescribedPoses::gain_pace(World& world, double h) {
  for (size_t b = 1; b < push_.size(); b++) {
    Push& p = push_[b];
    p.wait = std::max(0.0, p.wait - h);
    double& pace = world.prescribed_exits.pace[b];
    pace = p.wait > 0 ? 0 : pace == 0 ? 1 : std::min(1.0, tune::kPushGain * pace);
  }
}

// Upper bound of the speed of all points of an object [m/s].
double PrescribedPoses::fastest(const System& system, const Kinematics& k, int body,
                                const std::vector<Twist>& twists) const {
  double most = 0;
  for (const CollisionShape& m : system.world.shapes)
    if (m.body == body) most = std::max(most, system.speed_bound(k, m, twists));
  return most;
}

// The object keeps its place in this substep, whatever touches it.
void PrescribedPoses::jam(System& system, Step& step, int tree) {
  Model& model = system.model;
  for (int b = tree; b < model.nbody; b++) {
    if (model.root[b] != tree) continue;
    jammed_.push_back(b);
    model.held[b] = 1;
    for (int i = model.dof_first[b]; i < model.dof_first[b] + model.dof_count[b]; i++)
      step.v_free[i] = step.spin[i] = 0;
  }
}

void PrescribedPoses::release_jammed(Model& m) {
  for (int b : jammed_) m.held[b] = 0;
  jammed_.clear();
}

// Makes the push of an object gentler where it is thrown or has no room; true if that changed
// anything.
bool PrescribedPoses::soften(System& system, Data& data, int body, int tries) {
  World& world = system.world;
  const Kinematics& kin = data.state.pose.kin;
  double& pace = world.prescribed_exits.pace[body];
  if (world.prescribed_exits.squeezed[body]) pace = 0;
  const double pushed = world.settings.depenetration_speed;
  const double speed = fastest(system, kin, body, twists_);
  const double most =
      std::max(tuning::collision::kThrownFactor * pushed,
               tune::kThrownAcross * elementary::hypot(fastest(system, kin, body, free_), pushed));
  const int root = system.model.root[body];
  const bool room = data.attempt.settled(data.islands.of_tree(root)) && !data.attempt.relaxed[root];
  if (speed <= most && (room || pace == 0)) return false;
  if (pace == 0) {
    jam(system, data.step, system.model.root[body]);
  } else if (tries < tune::kPushTries) {
    pace *= room ? std::max(tune::kLeastPush, tune::kPushMargin * most / speed) : tune::kNoRoomPush;
  } else {
    Push& p = push_[body];
    p.wait = p.patience =
        std::min(tune::kMostPushWait, std::max(tune::kLeastPushWait, 2 * p.patience));
    pace = 0;
  }
  return true;
}

bool PrescribedPoses::accept(System& system, Data& data, int tries) {
  const Model& model = system.model;
  std::vector<char> inside(model.nbody, 0), forget(model.nbody, 0);
  for (const ContactCandidate& c : data.attempt.candidates)
    if (c.dist < 0 && c.other_shape >= 0 && system.is_person(system.world.shapes[c.shape].body))
      inside[system.world.shapes[c.other_shape].body] = 1;
  body_twists(model, data.state.pose.kin, data.step.v.data(), twists_);
  body_twists(model, data.state.pose.kin, data.step.v_free.data(), free_);
  bool good = true;
  for (int b = 1; b < model.nbody; b++) {
    if (!inside[b]) push_[b].patience = 0;
    if (!inside[b] || model.held[b] || !soften(system, data, b, tries)) continue;
    forget[model.root[b]] = 1;
    good = false;
  }
  // The impulses that pressed on it without end are no guess of those that press now.
  if (!good) data.cache.forget(system, forget);
  return good;
}

void PrescribedPoses::save(const World& world, std::vector<double>& out) const {
  for (size_t b = 0; b < push_.size(); b++)
    out.insert(out.end(), {world.prescribed_exits.pace[b], push_[b].wait, push_[b].patience});
}

const double* PrescribedPoses::load(World& world, const double* in) {
  for (size_t b = 0; b < push_.size(); b++, in += 3) {
    world.prescribed_exits.pace[b] = in[0];
    push_[b] = {in[1], in[2]};
  }
  return in;
}

}  // namespace hp
