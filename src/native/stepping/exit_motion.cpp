#include "stepping/exit_motion.h"

#include "tuning.h"

namespace hp {

namespace tune = tuning::stepping;

bool ExitMotion::begin(World& world) {
  if (!world.depenetration.any()) return false;
  world.depenetration.growth = std::min(1.0, tune::kExitGain * world.depenetration.growth);
  return true;
}

bool ExitMotion::accept(System& system, Data& data) {
  const double speed = excess_speed(system, data);
  if (data.attempt.good && speed <= tune::kExitSpeed) return true;
  const double slower =
      speed > tune::kExitSpeed ? tune::kExitMargin * tune::kExitSpeed / speed : tune::kExitCut;
  system.world.depenetration.growth *= std::max(tune::kLeastExitCut, slower);
  return false;
}

void ExitMotion::give_up(World& world) {
  kept_ = world.depenetration.growth;
  world.depenetration.growth = 0;
}

// By how much the fastest point of the trees that come out of something is faster than asked; kExitSpeed
// if none is by more [m/s].
double ExitMotion::excess_speed(System& system, Data& data) {
  const Model& model = system.model;
  const World& world = system.world;
  // What the motion asks; objects have none of their own.
  std::vector<double> asked(data.step.v_free);
  for (const Drive& d : system.drives) d.reference(asked.data());
  body_twists(model, data.state.pose.kin, data.step.v.data(), twists_);
  body_twists(model, data.state.pose.kin, asked.data(), asked_);
  std::vector<Twist> beside(asked_);
  for (size_t b = 0; b < beside.size(); b++)
    beside[b].w = twists_[b].w - asked_[b].w, beside[b].v = twists_[b].v - asked_[b].v;
  std::vector<char> tree(model.nbody, 0);
  for (const InitialOverlap& in : world.depenetration.overlaps()) tree[system.tree(in.shape)] = 1;
  double fastest = tune::kExitSpeed;
  for (size_t i = 0; i < world.shapes.size(); i++) {
    const CollisionShape& m = world.shapes[i];
    if (!tree[model.root[m.body]] || !world.active[m.body]) continue;
    if (system.speed_bound(data.state.pose.kin, m, beside) <= fastest) continue;
    fastest = fastest_point(system, data, (int)i, fastest);
  }
  return fastest;
}

double ExitMotion::fastest_point(System& system, Data& data, int shape, double least) const {
  Poses& pose = data.state.pose;
  const CollisionShape& m = system.world.shapes[shape];
  const Points p = system.world.place(pose, shape).points();
  const size_t n = p.n;
  double fastest = least;
  for (size_t k = 0; k < n; k++) {
    auto speed = [&](const std::vector<Twist>& twists) {
      Vec3 v;
      for (size_t t = 0; t < m.influences.size(); t++) {
        const double w = m.skin ? m.weights[t * n + k] : 1;
        if (w == 0) continue;
        const Twist& body = twists[m.influences[t].body];
        v += w * (body.v + cross(body.w, p.at((int)k) - pose.kin.reference(system.model, m.body)));
      }
      return norm(v);
    };
    fastest = std::max(fastest, speed(twists_) - speed(asked_));
  }
  return fastest;
}

void part_people(const System& system, Data& data) {
  const double speed = system.world.settings.depenetration_speed;
  std::vector<double>& v = data.step.v_free;
  for (const Parting& p : system.world.parting.all()) {
    const Drive &moved = system.drives[p.moved], &other = system.drives[p.other];
    if (!system.active(moved)) continue;
    double* at = &v[moved.first_dof()];
    const double lacks = speed - dot(load3(at) - load3(&v[other.first_dof()]), p.way);
    if (lacks <= 0) continue;
    store3(at, load3(at) + lacks * p.way);
    data.result.disturbed[moved.body(0)] = 1;
  }
}

void finish_parting(System& system, const Data& data, double h) {
  PeopleParting& parting = system.world.parting;
  const std::vector<double>& v = data.state.qvel;
  for (size_t k = 0; k < parting.all().size(); k++) {
    const Parting& p = parting.all()[k];
    const Drive &moved = system.drives[p.moved], &other = system.drives[p.other];
    if (!system.active(moved)) continue;
    const Vec3 apart = load3(&v[moved.first_dof()]) - load3(&v[other.first_dof()]);
    parting.advance(k, h * dot(apart, p.way), h * system.world.settings.depenetration_speed);
  }
}

bool comes_out(const System& system, const Drive& d) {
  if (system.world.parting.concerns((int)(&d - system.drives.data()))) return true;
  for (const InitialOverlap& in : system.world.depenetration.overlaps())
    if (system.tree(in.shape) == d.body(0)) return true;
  return false;
}

void start_exits(System& system, State& state) {
  std::vector<char>& path = state.exit_path;
  for (const InitialOverlap& in : system.world.depenetration.overlaps())
    for (int b = system.world.shapes[in.shape].body; b > 0 && !path[b]; b = system.model.parent[b])
      path[b] = 1;
  for (Drive& d : system.drives)
    if (comes_out(system, d) && !d.gentle())
      d.gentle_return.start(d, tune::kReturnSpeed, system.joint_reach);
}

void end_gentle_frame(System& system, const State& state) {
  for (Drive& d : system.drives)
    if (d.gentle())
      d.gentle_return.end_frame(d, comes_out(system, d), d.motion.frame_length(),
                                d.motion.target().data(), state.qpos.data());
}

}  // namespace hp
