#include "footing/footing.h"

#include <optional>

#include "tuning.h"

namespace hp {

namespace tune = tuning::footing;

namespace {

// Soles may be this much nearer to the ground than they are put [m]: who has not been lifted and stands
// clear of it, by as little as contact needs, keeps the motion's bits.
double tolerated(double height) {
  return tune::kAtHeight + (height == 0 ? tune::kSoleGap - tune::kLeastSoleGap : 0);
}

}  // namespace

// Where a foot is put, seen from the body.
Leg::Place Footing::place(size_t leg) const {
  const int ankle = model->legs[leg].ankle;
  const Quat foot = stance_.kin.xquat[ankle];
  const double up = lift_[leg] + footwork_.raised(leg) + left_up_[leg];
  const Vec3 by = footwork_.offset(leg) + Vec3{0, 0, up};
  Leg::Place to{stance_.kin.xpos[ankle] + by,
                stance_.feet[leg].turns ? normalized(stance_.feet[leg].turn * foot) : foot};
  if (norm2(left_turn_[leg]) > 0) to.foot = normalized(exp_quat(left_turn_[leg]) * to.foot);
  return to;
}

// A foot that was stopped goes on from where it is: up, down and turned it comes to its place with time.
void Footing::find_left(const Poses& poses, double dt) {
  const Kinematics &now = poses.kin, &body = stance_.body();
  const int root = model->legs[0].root;
  const Quat by = body.xquat[root] * conjugate(now.xquat[root]);
  for (size_t f = 0; f < model->legs.size(); f++) {
    double& up = left_up_[f];
    Vec3& turn = left_turn_[f];
    const int ankle = model->legs[f].ankle;
    if (footwork_.stopped(f)) {
      up = 0, turn = {};
      const Leg::Place to = place(f);
      up = (body.xpos[root] + to_matrix(by) * (now.xpos[ankle] - now.xpos[root])).z - to.ankle.z;
      turn = log_quat(by * now.xquat[ankle] * conjugate(to.foot));
      continue;
    }
    // Fast where nothing is in its way.
    const bool free = norm(now.xpos[ankle] - placed_[f]) < tune::kStopped;
    const double share = free ? 1 - elementary::exp(-tune::kSettlesRate * dt) : 0;
    const double down = std::max(tune::kSettles * dt, share * std::fabs(up));
    up -= std::clamp(up, -down, down);
    turn -= capped(turn, std::max(tune::kSettlesTurn * dt, share * norm(turn)));
  }
}

Footing::Height Footing::wanted_height(bool starts) const {
  // On a layer somebody starts anywhere between frame and surface, and else comes down until it presses.
  const double from = starts ? height_ : -1e300;
  if (sits()) return {true, std::clamp(from, under_.least_skin_lift(), under_.skin_lift())};
  // As high as one foot has it, no higher than the other leg reaches down.
  double highest = -1e300, most = 1e300;
  for (size_t f = 0; f < under_.feet.size(); f++) {
    const Stance::Foot& foot = stance_.feet[f];
    const double lift = std::clamp(from, under_.feet[f].least, under_.feet[f].lift);
    const double carries = stance_.carries(foot);
    if (!under_.feet[f].grounded || carries < tune::kAtRestShare) continue;
    const bool new_there = !starts && !stance_.drags && foot.rested < tune::kRestTime;
    if (new_there && lift < height_ - tune::kFar) continue;
    highest = std::max(highest, lift);
    most = std::min(most, lift + model->legs[f].slack(stance_.body(), footwork_.offset(f)));
  }
  if (highest == -1e300) return {};
  return {true, std::min(highest, most), most < highest};
}

void Footing::move_height(double dt, double gravity) {
  if (layers.carry()) return;  // they move it
  const Height wanted = wanted_height(false);
  if (!wanted.known) {
    rising_ = 0;
    return;
  }
  const double to = wanted.at;
  const bool near = to > height_ - tune::kFloats && to < height_ + tolerated(height_);
  if (near && std::fabs(rising_) < tune::kAtRest) {
    rising_ = 0;
    return;
  }
  // Slower where frames are long: else it would ring.
  const bool hangs = wanted.hangs && to < height_;
  const double rate =
      std::min(hangs ? tune::kHangingRate : tune::kHeightRate, tune::kHeightShare / dt);
  const double pull = rate * rate * (to - height_) - 2 * rate * rising_;
  rising_ += dt * std::clamp(pull, -gravity, tune::kRise * gravity);
  height_ += dt * rising_;
  if (std::fabs(height_ - to) < tune::kAtHeight && std::fabs(rising_) < tune::kAtRest)
    height_ = to, rising_ = 0;
}

// After the height has gone down from `from`: no further than nothing sinks into the ground; but whoever is
// far above what it is to stand on falls, whatever its hands are over.
void Footing::come_down(const CollisionWorld& world, Vec3 displaced, double from, double dt) {
  if (height_ >= from || layers.carry()) return;
  const Height wanted = wanted_height(false);
  const bool falls = dt > 0 && wanted.known && wanted.at < from - tune::kFallsPastHands;
  const double least = std::min(
      from,
      Underfoot::least_height(world, *model, stance_, {displaced.x, displaced.y, from}, !falls));
  if (height_ >= least) return;
  height_ = least;
  rising_ = dt > 0 ? (height_ - from) / dt : 0;
}

// Who has a layer under a foot, or is carried by one, wades.
void Footing::wade(const Model& m, double dt) {
  bool any = layers.carry();
  for (const Underfoot::Foot& foot : under_.feet) any |= foot.on_layer();
  if (!any) return wading.leave();
  wading.frame(*model, stance_, footwork_, under_, stance_.centre_of_mass(m), dt);
}

// How far a foot is to be lifted by the end of a frame, for what it comes to and passes over by `gap`: the nearer that
// is the faster,
//
//   u' = c (needed - u) / t^2,   t: the time until then
double Footing::lift_for_soon(size_t leg, double height, double gap, double dt) const {
  double lift = -1e300;
  for (int k = 0; k < tune::kLooks; k++) {
    if (under_.feet[leg].soon[k] == -1e300) continue;
    const double more = under_.feet[leg].soon[k] + gap - height - lift_[leg];
    const double time = k * tune::kLookTime;  // it may come there an interval earlier
    const double share = time > dt ? std::min(1.0, tune::kLookPace * dt / (time * time)) : 1;
    lift = std::max(lift, lift_[leg] + share * more);
  }
  return lift;
}

// How far a foot is to be lifted beyond the person's height, which will be `height` and has grown by `rose`.
double Footing::wanted_lift(size_t leg, double height, double rose, double rises, double dt) {
  const Stance::Foot& foot = stance_.feet[leg];
  const Underfoot::Foot& under = under_.feet[leg];
  double lift = lift_[leg], up = 0, down = tune::kLowerRate;
  if (under.grounded) {
    up = under.lift - height;
    // The lowest foot of a dance on sliding feet carries, and does not pass over the ground.
    const double carries = std::max(foot.rests, stance_.carries(foot));
    const double swings = (1 - carries) * tune::kSwingGap;
    if (up > -swings) up += swings;
    const bool far =
        sits() ? up < -tune::kHangs : up < -tune::kFar && foot.rested < tune::kRestTime;
    if (lift == 0 && up < tolerated(height)) up = std::min(up, 0.0);
    if (up < tune::kAtHeight) up = far ? 0 : foot.rests * std::min(0.0, up + tune::kFloats);
    // A foot on a layer sinks with the body, to the frame if contacts let it, and leaves it upwards.
    const double sunk = under.lift - height;
    if (under.on_layer() && sunk > 0) {
      if (!sits()) up = wading.lift(stance_, leg, sunk, rises), down = tune::kWadeLower;
      if (sits() && layers.carry()) up *= 1 - carries;
    }
  }
  // A sole does not go up with a person who rises faster than legs would follow.
  const double carried_up = std::max(0.0, rose - tune::kRisesSlowly * dt);
  lift = std::max(lift - carried_up, std::min(lift, up + tune::kHangsBehind));
  const double gap = (1 - foot.rests) * tune::kSwingGap, soon = lift_for_soon(leg, height, gap, dt);
  // Feet of who sits, which carry nothing, come back from below at once.
  const double at_once = sits() ? up : std::min(up, under.lift + gap - height);
  const double least = std::max(soon, at_once);
  up = std::max(up, soon);
  // It comes back to the motion from ground below it as it has gone there. Implicit: no step is too long.
  double& sinking = sinking_[leg];
  const double h = dt * down;
  sinking = (sinking + h * down * (up - lift)) / ((1 + h) * (1 + h));
  double to = lift + dt * sinking;
  if (to < least) {
    // Up it goes at once where it must; what rests has crept over an edge, and is in no hurry.
    const bool creeps =
        !under.on_layer() && foot.rests > tune::kAtRestShare && least > lift + tune::kSameLevel;
    to = std::max(to, std::min(least, lift + (creeps ? tune::kLiftAtRest : tune::kLift) * dt));
    sinking = std::clamp(sinking, 0.0, down * std::max(0.0, up - to));
  }
  lift = to;
  return std::fabs(lift) < tune::kAtHeight ? 0 : lift;
}

// What moves a foot in a frame: the body beside its motion, and what kept it from its place in the last one.
Footwork::Foot Footing::moved_foot(const Poses& poses, size_t leg, Vec3 slid,
                                   const Frame& frame) const {
  const Stance::Foot& seen = stance_.feet[leg];
  const Underfoot::Foot& under = under_.feet[leg];
  const int ankle = model->legs[leg].ankle;
  Footwork::Foot foot;
  foot.rests = seen.rests, foot.rested = seen.rested, foot.held = seen.held;
  foot.grounded = under.grounded;
  const double above = height_ + lift_[leg] + left_up_[leg] - under.lift;
  foot.stands = under.grounded && seen.rests > tune::kAtRestShare && above < tune::kStands;
  foot.slid = slid;
  // What stands in a layer is held by friction there.
  const bool sunk = wades() && under.on_layer() && under.lift > height_ + lift_[leg];
  if (sunk) foot.slid = frame.returns;
  if (placed_known_) {
    const Vec3 missed = poses.kin.xpos[ankle] - placed_[leg];
    foot.missed = {missed.x, missed.y, 0};
    foot.stands &= std::fabs(missed.z) < tune::kStopped;
    if (sunk && norm(foot.missed) > tune::kStopped) foot.slid = {};
  }
  if (sunk) return foot;
  const Quat turns = stance_.heading_change();
  const Vec3 aside = stance_.goes_aside();
  if (turns.z == 0 && norm2(aside) == 0) return foot;
  const Vec3 arm = stance_.kin.xpos[ankle] - stance_.kin.xpos[model->legs[leg].root];
  const Vec3 carried = arm - to_matrix(conjugate(turns)) * arm;
  foot.slid += Vec3{carried.x, carried.y, 0} + aside;
  foot.turned = log_quat(turns).z;
  return foot;
}

// The feet keep their places while the body goes beside its motion, or step.
void Footing::move_feet(const CollisionWorld& world, Poses& poses, const Frame& frame) {
  Vec3 slid = frame.displaced - displaced_;
  slid.z = 0;
  if (norm(slid) < tune::kNoWay) slid = {};
  std::vector<Footwork::Foot> feet;
  for (size_t f = 0; f < under_.feet.size(); f++) feet.push_back(moved_foot(poses, f, slid, frame));
  const Vec3 whole{frame.displaced.x, frame.displaced.y, height_};
  footwork_.frame(feet, !sits() && !stance_.flies(), frame.view.dt,
                  [&](size_t leg, Vec3 offset, double turn) {
                    return Underfoot::lands(world, poses, model->legs[leg], stance_,
                                            whole + offset + Vec3{0, 0, lift_[leg]}, turn);
                  });
}

// After the heights are known: what is on the ground at the end of the frame.
void Footing::find_state() {
  over_ground_ = on_ground_ = sits();
  for (size_t f = 0; f < under_.feet.size(); f++) {
    const Underfoot::Foot& under = under_.feet[f];
    over_ground_ |= under.grounded;
    // Who has been stopped stands, though its feet may still come down to their places.
    on_ground_ |= under.grounded && under.lift > height_ + lift_[f] - tune::kOnGround;
  }
}

// Which points carry the person where it is put: what rests, near a surface. After the heights are known.
void Footing::find_bearing(const Model& m, const CollisionWorld& world, Vec3 displaced, double dt) {
  const auto carries = [&](size_t i, Vec3 by, double rests) {
    BearingPoint& p = bearing.points[i];
    if (p.carries == 0) return;
    const Vec3 x = stance_.points[i] + by;
    const double gap = x.z - p.at.z - world.settings.clearance;
    p.at = {x.x, x.y, p.at.z};
    p.gap = gap;
    p.carries = rests * fades(stance_.speed[i], tune::kRests, tune::kMoves) *
                fades(gap, tune::kPresses, tune::kPressesNot);
    if (p.on_layer) p.carries = 0;
    if (p.shape < 0) return;
    const int body = world.shapes[p.shape].body;
    if (m.pushed_dof(body) < 0) p.shape = -1;
  };
  size_t i = 0;
  double limp = 0;  // share of the weight that hangs on the feet if legs do nothing
  const Vec3 whole{displaced.x, displaced.y, height_ + std::max(0.0, displaced.z)};
  for (size_t f = 0; f < under_.feet.size(); f++) {
    const Leg& leg = model->legs[f];
    double best = 0;
    for (size_t n = 0; n < leg.sole.size(); n++, i++) {
      const double up = lift_[f] + left_up_[f] + footwork_.raised(f);
      carries(i, whole + footwork_.offset(f) + Vec3{0, 0, up}, stance_.low[i]);
      best = std::max(best, bearing.points[i].carries);
    }
    limp += best *
            (0.5 * m.mass[leg.hip] + m.mass[leg.knee] + m.mass[leg.ankle] + m.mass[leg.toes]) /
            m.carried[leg.root];
  }
  const size_t soles = i;
  for (; i < stance_.points.size(); i++) carries(i, whole, 1);
  const Vec3 centre = stance_.centre_of_mass(m) + whole;
  layers.aim(bearing.points, soles, limp, centre, sits());
  bearing.aim(centre, 1 - layers.share(), dt);
}

void Footing::apply(int root_qpos, double* qpos) {
  corrected_ = height_ != 0;
  placed_known_ = true;
  const Vec3 whole = displaced_ + Vec3{0, 0, height_};
  qpos[root_qpos + 2] += height_;
  auto below = under_.ground.begin();
  std::vector<double> ground;  // of a foot, as the reference sees it
  for (size_t f = 0; f < model->legs.size(); f++) {
    ground.assign(below, below + model->legs[f].sole.size());
    below += ground.size();
    for (double& z : ground) z -= height_ + held_up_;
    const Leg::Place to = place(f);
    const Vec3 from = stance_.kin.xpos[model->legs[f].ankle];
    placed_[f] = to.ankle + whole;
    const bool turned = stance_.feet[f].turns || norm2(left_turn_[f]) > 0;
    const bool moved = to.ankle.x != from.x || to.ankle.y != from.y || to.ankle.z != from.z;
    if (!moved && !turned && !stance_.tilts()) continue;
    const Vec3 reached = model->legs[f].move(stance_.body(), to, ground, qpos);
    const Vec3 made = reached - from;
    placed_[f] = reached + whole;
    footwork_.reached(f, made);
    lift_[f] = made.z - footwork_.raised(f) - left_up_[f];
    // A foot that is not lifted is known by its zero, not by what rounding leaves of it.
    if (std::fabs(lift_[f]) < tune::kAtHeight) lift_[f] = 0;
    corrected_ = true;
  }
}

// Joints turn at constant rates between two targets, so that a foot that rolls off its toes sags on its
// way, by millimetres. Lifts feet that would be under the ground half-way; true if there are any.
bool Footing::clear_between(const Model& m, const CollisionWorld& world, Poses& poses,
                            int root_qpos, const double* from, const double* to) {
  half_.assign(to, to + m.nq);
  double* q = &half_[root_qpos];
  for (int i = 0; i < 3; i++) q[i] = 0.5 * (from[i] + q[i]);
  for (int b = 1; b < m.nbody; b++) {
    if (!stance_.own()[b] || m.jnt_count[b] == 0) continue;  // what is held has no joint
    const int at = m.jnt_qpos[m.jnt_first[b]] + (m.parent[b] == 0 ? 3 : 0);
    const Quat begin = load4(from + at - root_qpos), end = load4(to + at);
    Quat half = begin * exp_quat(0.5 * log_quat(conjugate(begin) * end));
    if (m.parent[b] == 0) half = stance_.turned_half_way() * half;
    store4(&half_[at], normalized(half));
  }
  between_.resize(m);
  between_.update(m, half_.data(), stance_.own());
  bool any = false;
  size_t i = 0;
  std::optional<SurfaceBelow> surface;  // few frames ask
  for (size_t f = 0; f < model->legs.size(); f++) {
    double sags = 0;
    for (const SkinPoint& p : model->legs[f].sole) {
      const Vec3 x = p.position(between_);
      const double lower = held_up_ + x.z;
      // Of what it comes to only what is under it already: no stair over whose edge it goes.
      if (under_.ground[i] - lower > std::max(sags, tune::kSags)) {
        if (!surface) surface.emplace(world, stance_.own());
        sags = std::max(sags, under_.ground_at(world, poses, *surface, i, x) - lower);
      }
      i++;
    }
    if (sags < tune::kSags) continue;
    lift_[f] += std::min(2 * sags, tune::kMostSag);
    any = true;
  }
  return any;
}

void Footing::clear() {
  const size_t legs = model->legs.size();
  height_ = rising_ = 0;
  corrected_ = placed_known_ = over_ground_ = on_ground_ = bottoms_ = false;
  folds_ = 0;
  under_ = {};
  displaced_ = {};
  bearing.reset();
  layers.reset();
  wading.clear(legs);
  way.clear();
  stance_.clear(legs);
  footwork_.clear(legs);
  for (auto* v : {&lift_, &sinking_, &left_up_}) v->assign(legs, 0);
  for (auto* v : {&placed_, &left_turn_}) v->assign(legs, {});
}

void Footing::start(const Model& m, const CollisionWorld& world, Poses& poses, int root_qpos,
                    double* qpos) {
  if (!on()) return;
  clear();
  stance_.read(m, *model, footwork_, {}, qpos);
  under_.find(world, poses, *model, stance_, footwork_, {}, height_, bearing);
  const Height wanted = wanted_height(true);
  double height = wanted.at;
  if (!wanted.known || std::fabs(height) > tune::kStartShift) return;
  if (height < tolerated(height_) && height > -tune::kFloats) height = 0;
  height_ = height;
  come_down(world, {}, 0, 0);
  for (size_t f = 0; f < under_.feet.size(); f++) {
    const double up = wanted_lift(f, height_, 0, 0, 1);
    if (std::fabs(up) < tune::kStartShift) lift_[f] = up;
  }
  apply(root_qpos, qpos);
}

bool Footing::bears(int toes) const {
  for (size_t f = 0; f < under_.feet.size(); f++) {
    if (model->legs[f].toes != toes) continue;
    const Underfoot::Foot& under = under_.feet[f];
    // That a foot is still above its place does not matter: its toes are to be firm as they come down.
    const bool near = under.lift > height_ + lift_[f] - tune::kBears;
    const Stance::Foot& foot = stance_.feet[f];
    const double carries = stance_.carries(foot);
    return under.grounded && near && !footwork_.steps(f) && carries > 0;
  }
  return false;
}

void Footing::frame(const Model& m, const CollisionWorld& world, Poses& poses, int root_qpos,
                    const Frame& frame, double* target) {
  // Who has nothing to stand on neither waits on its feet nor makes up for how it is turned.
  Stance::View view = frame.view;
  if (!over_ground_) view.waits = 0, view.turned = {};
  // Legs of who lies on layers lie with the body.
  if (sits() && layers.carry() && !layers.feet().on) view.turned = {};
  const double dt = view.dt, from = height_;
  stance_.read(m, *model, footwork_, view, target);
  under_.find(world, poses, *model, stance_, footwork_, frame.displaced, height_, bearing);
  move_height(dt, view.gravity);
  come_down(world, frame.displaced, from, dt);
  wade(m, dt);
  const double least = least_height();
  bottoms_ = height_ + frame.rises < least;
  const double lower = least - height_ - frame.displaced.z;
  folds_ = wades() ? 1 - fades(lower, tune::kUnfolded, tune::kFolded) : 0;
  const double ahead = std::max(height_ + frame.rises, std::min(height_, least));
  const double rises = dt > 0 && layers.carry() ? frame.rises / dt : 0;
  held_up_ = frame.held_up;
  for (size_t f = 0; f < under_.feet.size(); f++) {
    // Feet that the motion has on the ground are put there from where contacts hold who sits.
    const double on_ground = fades(-under_.feet[f].lift, tune::kOnFloor, tune::kOffFloor);
    lift_[f] = wanted_lift(f, ahead + on_ground * held_up_, height_ - from, rises, dt);
  }
  move_feet(world, poses, frame);
  find_left(poses, dt);
  displaced_ = frame.displaced;
  find_state();
  find_bearing(m, world, frame.displaced, dt);
  asked_.assign(target, target + m.nq);
  apply(root_qpos, target);
  if (!corrected_ || !clear_between(m, world, poses, root_qpos, frame.from, target)) return;
  std::copy(asked_.begin(), asked_.end(), target);
  apply(root_qpos, target);
}

// Begins with its length: whoever takes the state over may have no footing, or another.
void Footing::save(std::vector<double>& out) const {
  const size_t at = out.size();
  out.push_back(0);
  if (!on()) return;
  out.insert(out.end(), {height_, rising_, corrected_ ? 1.0 : 0.0, placed_known_ ? 1.0 : 0.0,
                         over_ground_ ? 1.0 : 0.0, on_ground_ ? 1.0 : 0.0, under_.highest(),
                         under_.skin_lift(), displaced_.x, displaced_.y, displaced_.z, folds_});
  for (const auto* v : {&lift_, &sinking_, &left_up_}) out.insert(out.end(), v->begin(), v->end());
  for (size_t f = 0; f < lift_.size(); f++) out.push_back(under_.stands(f));
  for (const auto* v : {&left_turn_, &placed_})
    for (Vec3 x : *v) out.insert(out.end(), {x.x, x.y, x.z});
  stance_.save(out);
  footwork_.save(out);
  bearing.save(stance_.count(), out);
  layers.save(out);
  wading.save(out);
  way.save(out);
  out[at] = (double)(out.size() - at - 1);
}

const double* Footing::load(const double* in) {
  const double* end = in + 1 + (size_t)*in;
  const bool any = *in++ > 0;
  if (!on()) return end;
  clear();
  if (!any) return end;
  height_ = in[0], rising_ = in[1], corrected_ = in[2] != 0;
  placed_known_ = in[3] != 0, over_ground_ = in[4] != 0, on_ground_ = in[5] != 0;
  const double highest = in[6], skin_lift = in[7];
  displaced_ = load3(in + 8), folds_ = in[11], in += 12;
  std::vector<double> stands(lift_.size());
  for (auto* v : {&lift_, &sinking_, &left_up_, &stands})
    for (double& x : *v) x = *in++;
  under_.restore(highest, skin_lift, stands);
  for (auto* v : {&left_turn_, &placed_})
    for (Vec3& x : *v) x = load3(in), in += 3;
  in = stance_.load(in, *model);
  in = footwork_.load(in, model->legs.size());
  in = bearing.restore(stance_.count(), in);
  in = layers.restore(in);
  in = wading.load(in);
  way.load(in);
  return end;
}

}  // namespace hp
