#include "stepping/aiming.h"

#include "tuning.h"

namespace hp {

namespace footing_tune = tuning::footing;

namespace {

// Has a contact pushed any of a person's bodies within the last kTouchedTime? What a wader stands in is none.
bool touched(const Drive& d) {
  if (d.footing.on() && d.footing.wades()) return d.footing.wading.hindered();
  return d.lately();
}

// Nothing but the ground, through the feet, moves a person as a whole: its weight pulls it down, legs
// push it up, and along the ground it pushes with what does not tip it over; who sits or lies does not tip,
// and moves on its seat with all it has. In the air it does none. `above`: how far it is above its target [m].
void limit_root_force(const System& system, Drive& d, double above) {
  d.root_force.on = d.footing.over_ground() && !d.limits.empty();
  if (!d.root_force.on) return;
  const double weight = norm(system.gravity) * system.model.carried[d.body(0)];
  const bool stands = d.carried || (d.footing.on_ground() && above < footing_tune::kOnGround);
  const double push = d.sits ? d.limits[0] : std::min(d.limits[0], footing_tune::kPush * weight);
  d.root_force.across = stands ? push : footing_tune::kInTheAir;
  d.root_force.up = stands ? d.limits[0] : footing_tune::kInTheAir;
  d.root_force.down = weight;
  d.root_force.falls = !stands;
}

// Who is off the path where something is in between goes round it, as fast as the motion and the way back
// together.
void go_round(const System& system, Drive& d, const double* qpos, const double* target, double dt) {
  const DriveSettings& s = system.drive_settings;
  Footing& footing = d.footing;
  const Vec3 at = load3(qpos + d.first_qpos()), to = load3(target);
  const Vec3 off{to.x - at.x, to.y - at.y, 0};
  const bool may = s.recover_root && !d.sits && footing.on_ground() && d.motion.eager > 0;
  if (!may || norm(off) < footing_tune::kOffPath || !(footing.way.on() || touched(d))) {
    footing.way.clear();
    return;
  }
  const Vec3 next = footing.way.next(system.world, at, to, footing.ground(), dt);
  if (!footing.way.on()) return;
  const Vec3 way{next.x - at.x, next.y - at.y, 0};
  const Vec3 motion = (1 / dt) * (to - load3(d.motion.target().data()));
  const double speed =
      d.clock.eager() * footing.pace(way) *
      std::max(s.root_speed,
               footing_tune::kCatchesUp * std::sqrt(motion.x * motion.x + motion.y * motion.y));
  d.motion.goes_round = true;
  d.motion.goes = (speed / std::max(norm(way), footing_tune::kReached)) * way;
}

// Who is blocked comes back to the pose of the motion slowly, so that it does not kick itself off.
void yield(const System& system, Drive& d) {
  d.yields.clear();
  if (!d.clock.blocked()) return;
  d.yields = return_rates(d, footing_tune::kYieldSpeed, system.joint_reach);
  d.yields[0] = footing_tune::kYieldTurn;
}

// How fast a frame towards `target` moves the root [m/s]: a turn counts at kTurnArm.
double root_speed(const Drive& d, const double* target, double dt) {
  const double* before = d.motion.target().data();
  const int turn = d.balls()[0].qpos;
  const double way = norm(load3(target) + Vec3{0, 0, d.footing.height()} - load3(before));
  return (way + footing_tune::kTurnArm * norm(rotation_between(before + turn, target + turn))) / dt;
}

}  // namespace

// The collision world starts again, as in Stepper::reset().
void Aiming::restart_world(System& system, State& state) {
  system.world.broad_phase.forget();
  state.pose_known = false;
  state.update_pose(system);
  system.world.reset(system.model, state.pose);
}

// Puts people on what is under them; true if anybody was moved.
bool Aiming::stand(System& system, State& state) {
  bool any = false;
  for (Drive& d : system.drives) {
    d.footing.start(system.model, system.world, state.pose, d.first_qpos(), state.qpos.data());
    any |= d.footing.corrected();
  }
  return any;
}

std::vector<Aiming::Depth> Aiming::depths(const System& system) {
  std::vector<Depth> out;
  for (const InitialOverlap& in : system.world.depenetration.overlaps()) {
    const int other = in.other_shape < 0 ? -1 : system.tree(in.other_shape);
    out.push_back({system.tree(in.shape), in.other_static, other, in.depth()});
  }
  return out;
}

// Is a person deeper in anything than it was?
bool Aiming::deeper(const std::vector<Depth>& before, const std::vector<Depth>& after, int person) {
  for (const Depth& now : after) {
    if (now.person != person && now.other_tree != person) continue;
    double was = 0;
    for (const Depth& b : before)
      if (b.person == now.person && b.other_static == now.other_static &&
          b.other_tree == now.other_tree)
        was = std::max(was, b.depth);
    if (now.depth > was + footing_tune::kDeeperAtStart) return true;
  }
  return false;
}

void Aiming::start(System& system, State& state) {
  const std::vector<double> asked = state.qpos;
  const std::vector<Depth> before = depths(system);
  if (!stand(system, state)) return;
  restart_world(system, state);
  const std::vector<Depth> after = depths(system);
  bool back = false;
  for (Drive& d : system.drives) {
    if (!d.footing.corrected()) continue;
    if (deeper(before, after, d.body(0))) {
      std::copy_n(&asked[d.first_qpos()], d.qpos_count(), &state.qpos[d.first_qpos()]);
      d.footing.clear();
      back = true;
    }
    d.reset(&state.qpos[d.first_qpos()], state.qvel.data());
  }
  if (back) restart_world(system, state);
}

void Aiming::begin(System& system, Data& data, const double* targets, double dt) {
  State& state = data.state;
  const DriveSettings& s = system.drive_settings;
  data.result.clear(system.model.nbody);
  state.update_pose(system);
  for (Drive& d : system.drives) {
    d.motion.goes_round = false;
    Vec3 displaced = d.motion.displaced(s, targets, dt, state.qpos.data());
    // Who has been lifted onto something stands there, and not on what is below; who rests on soft layers
    // is as high as they have it.
    const bool lifted = d.carried && displaced.z > footing_tune::kRaised;
    if (d.footing.on() && (lifted || d.footing.layers.carry())) {
      const double by = lifted ? displaced.z : d.footing.sink(displaced.z);
      d.footing.raise(by);
      d.motion.raise(by);
      displaced.z -= by;
    }
    const bool stands = !d.footing.on() || !d.footing.flies();
    // Who sits or lies is held by what is under it, not blocked on its way.
    const Vec3 behind = d.sits ? Vec3{} : displaced;
    const double* target =
        d.clock.advance(d, targets, dt, behind, touched(d), stands, d.footing.way.on());
    targets += d.qpos_count();
    if (d.footing.on()) d.footing.layers.move(root_speed(d, target, dt), d.sits, dt);
    // Who rests on layers stays where they hold it.
    d.motion.eager = d.clock.eager() * d.footing.pace(-displaced) * (1 - d.footing.layers.rest());
    yield(system, d);
    if (d.footing.on()) {
      go_round(system, d, state.qpos.data(), target, dt);
      target_ = state.qpos;
      std::copy_n(target, d.qpos_count(), &target_[d.first_qpos()]);
      place_feet(system, state, d, target, dt);
      target = &target_[d.first_qpos()];
      const double above = state.qpos[d.first_qpos() + 2] - d.motion.target()[2];
      d.sits = d.footing.sits() || (d.sits && d.carried);
      limit_root_force(system, d, above);
    }
    d.aim(s, target, dt, state.qpos.data());
  }
}

// Puts the feet of target_ where they are to be.
void Aiming::place_feet(System& system, State& state, Drive& d, const double* asked, double dt) {
  const DriveSettings& s = system.drive_settings;
  const double* qpos = state.qpos.data();
  Footing::Frame frame;
  const Drive::Ahead ahead = d.ahead(s, asked, dt, qpos);
  frame.from = d.motion.target().data();
  frame.displaced = d.motion.displaced(s, asked, dt, qpos);
  frame.returns = frame.displaced - (load3(qpos + d.first_qpos()) - load3(frame.from));
  frame.returns.z = 0;
  if (d.sits) frame.held_up = std::max(0.0, frame.displaced.z);
  frame.displaced += Vec3{ahead.drift.x, ahead.drift.y, 0};
  frame.rises = ahead.drift.z;
  frame.view = {dt, d.clock.passed(), norm(system.gravity), ahead.turned,
                std::max(0.0, 1 - d.clock.rate())};
  d.footing.frame(system.model, system.world, state.pose, d.first_qpos(), frame, target_.data());
  for (size_t f = 0; f < d.footing.model->legs.size(); f++) {
    if (!d.footing.goes_on(f)) continue;
    const Leg& leg = d.footing.model->legs[f];
    for (int at : {leg.hip_qpos, leg.knee_qpos, leg.ankle_qpos})
      d.motion.go_on(at - d.first_qpos(), &qpos[at]);
  }
}

void Aiming::end(System& system, const FrameResult& result) {
  std::vector<double> up(system.model.nbody, 0);  // [N s]
  std::vector<char> aside(system.model.nbody, 0);
  auto look = [&](int shape, Vec3 impulse) {
    if (shape < 0 || !(norm2(impulse) > 0)) return;
    if (impulse.z > footing_tune::kHeldUp * norm(impulse))
      up[system.tree(shape)] += impulse.z;
    else
      aside[system.tree(shape)] = 1;
  };
  for (const Touch& t : result.touches) {
    if (t.other_shape >= 0 && system.tree(t.shape) == system.tree(t.other_shape)) continue;
    look(t.shape, t.impulse), look(t.other_shape, -t.impulse);
  }
  for (Drive& d : system.drives) {
    const double weight = norm(system.gravity) * system.model.carried[d.body(0)];
    const double dt = d.motion.frame_length();
    // Who comes to sit presses as little on the seat, at first.
    d.carried = up[d.body(0)] > (d.sits ? 0 : footing_tune::kCarriedShare) * dt * weight;
    d.footing.wading.pushed(aside[d.body(0)], dt);
  }
}

}  // namespace hp
