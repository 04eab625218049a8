#include "footing/footing.h"

#include "tuning.h"

namespace hp {

namespace tune = tuning::footing;

namespace {

// 1 up to `low`, 0 from `high` on.
double fades(double x, double low, double high) {
  return std::clamp((high - x) / (high - low), 0.0, 1.0);
}

Vec3 capped(Vec3 v, double most) {
  const double size = norm(v);
  return size > most ? (most / size) * v : v;
}

// Soles may be this much nearer to the ground than they are put [m]: who has not been lifted and stands
// clear of it, by as little as contact needs, keeps the motion's bits.
double tolerated(double height) {
  return tune::kAtHeight + (height == 0 ? tune::kSoleGap - tune::kLeastSoleGap : 0);
}

}  // namespace

// How the body is turned off the motion: about the vertical, and besides. Less than rounding is nothing.
void Footing::turn(Quat turned) {
  turned_before_ = turned_, heading_before_ = heading_;
  turned_ = turned, heading_ = {};
  const double size = std::sqrt(turned.w * turned.w + turned.z * turned.z);
  if (turned.z != 0 && size > tune::kUpsideDown) heading_ = {turned.w / size, 0, 0, turned.z / size};
  tilts_ = turned.x != 0 || turned.y != 0;
}

// The poses of the reference `qpos`, turned like the body.
void Footing::pose(const Model& m, int root_qpos, const double* qpos) {
  own_.assign(m.nbody, 0);
  const int root = m.root[model->legs[0].hip];
  for (int b = 1; b < m.nbody; b++) own_[b] = m.root[b] == root;
  const auto turn = [&](Kinematics& kin, Quat by) {
    kin.resize(m);
    half_.assign(qpos, qpos + m.nq);
    double* q = &half_[root_qpos + 3];
    if (by.w != 1) store4(q, normalized(by * load4(q)));
    kin.update(m, half_.data(), own_.data());
  };
  turn(kin_, heading_);
  if (tilts_) turn(tilted_, turned_);
}

// Where a foot is put, seen from the body.
Leg::Place Footing::place(size_t leg) const {
  const int ankle = model->legs[leg].ankle;
  const Quat foot = kin_.xquat[ankle];
  const double up = lift_[leg] + footwork_.raised(leg) + left_up_[leg];
  const Vec3 by = footwork_.offset(leg) + Vec3{0, 0, up};
  Leg::Place to{kin_.xpos[ankle] + by, foot_turns_[leg] ? normalized(foot_turn_[leg] * foot) : foot};
  if (norm2(left_turn_[leg]) > 0) to.foot = normalized(exp_quat(left_turn_[leg]) * to.foot);
  return to;
}

// A foot that was stopped goes on from where it is: up, down and turned it comes to its place with time.
void Footing::find_left(const Poses& poses, double dt) {
  const Kinematics &now = poses.kin, &body = tilts_ ? tilted_ : kin_;
  const int root = model->legs[0].root;
  const Quat by = body.xquat[root] * conjugate(now.xquat[root]);
  for (size_t f = 0; f < model->legs.size(); f++) {
    double& up = left_up_[f];
    Vec3& turn = left_turn_[f];
    if (footwork_.stopped(f)) {
      const int ankle = model->legs[f].ankle;
      up = 0, turn = {};
      const Leg::Place to = place(f);
      up = (body.xpos[root] + to_matrix(by) * (now.xpos[ankle] - now.xpos[root])).z - to.ankle.z;
      turn = log_quat(by * now.xquat[ankle] * conjugate(to.foot));
      continue;
    }
    up -= std::clamp(up, -tune::kSettles * dt, tune::kSettles * dt);
    turn -= capped(turn, tune::kSettlesTurn * dt);
  }
}

// What rests in the reference, seen from how fast and how low its points are; who waits stands on both feet,
// and level.
void Footing::find_rest(double waits) {
  size_t i = 0;
  low_.clear();
  for (size_t f = 0; f < model->legs.size(); f++) {
    const Leg& leg = model->legs[f];
    double rests = 0;
    feet_[f].low = 0;
    for (size_t n = 0; n < leg.sole.size(); n++, i++) {
      low_.push_back(fades(own_points_[i].z - flight_.lowest(), tune::kLow, tune::kHigh));
      feet_[f].low = std::max(feet_[f].low, low_.back());
      rests = std::max(rests, low_.back() * fades(speed_[i], tune::kRests, tune::kMoves));
    }
    held_[f] = waits > tune::kAtRestShare;
    rests_[f] = std::max(rests, waits);
    for (size_t k = i - leg.sole.size(); k < i; k++) low_[k] = std::max(low_[k], waits);
    const Vec3 up = kin_.xmat[leg.ankle].col(1);
    const double angle = footwork_.turn(f);
    foot_turns_[f] = waits > 0 || angle != 0;
    if (!foot_turns_[f]) continue;
    const Vec3 axis = cross(up, {0, 0, 1});
    const double sine = norm(axis), tilt = std::atan2(sine, up.z);
    foot_turn_[f] = exp_quat({0, 0, angle});
    if (sine > 0) foot_turn_[f] = foot_turn_[f] * exp_quat((waits * tilt / sine) * axis);
  }
}

// Where the points of the reference are, seen from the body, and how fast they got there; if no time passed,
// as before.
void Footing::read(const Model& m, const double* qpos, const Frame& frame) {
  const int root = m.root[model->legs[0].hip];
  pose(m, m.jnt_qpos[m.jnt_first[root]], qpos);
  own_points_.clear();
  for (const Leg& leg : model->legs)
    for (const SkinPoint& p : leg.sole) own_points_.push_back(p.position(kin_));
  for (const SkinPoint& p : model->skin) own_points_.push_back(p.position(kin_));
  points_ = own_points_;
  if (heading_.z != 0) {
    const Vec3 at = kin_.xpos[root];
    const Mat3 back = to_matrix(conjugate(heading_));
    for (Vec3& p : own_points_) p = at + back * (p - at);
  }
  speed_.resize(points_.size());
  if (!started_) speed_.assign(points_.size(), 0);
  if (started_ && frame.dt > tune::kNoTime)
    for (size_t i = 0; i < points_.size(); i++)
      speed_[i] = norm(own_points_[i] - before_[i]) / frame.dt;
  before_ = own_points_;
  started_ = true;
  double lowest = 1e300;
  for (const Vec3& p : own_points_) lowest = std::min(lowest, p.z);
  flight_.see(kin_.xpos[root].z, lowest, frame.passed, frame.gravity);
  feet_.assign(model->legs.size(), {});
  find_rest(flight_.flies() || !over_ground_ ? 0 : frame.waits);
  drags_ = !flight_.flies();
  for (double rests : rests_) drags_ &= rests <= tune::kAtRestShare;
  size_t i = 0;
  for (size_t f = 0; f < model->legs.size(); f++) {
    const size_t n = model->legs[f].sole.size();
    const Vec3 ankle = kin_.xpos[model->legs[f].ankle];
    const Mat3 turn = to_matrix(foot_turn_[f]);
    for (size_t k = 0; k < n && foot_turns_[f]; k++)
      points_[i + k] = ankle + turn * (points_[i + k] - ankle);
    i += n;
  }
}

void Footing::find_feet(const CollisionWorld& world, Poses& poses, Vec3 displaced, double dt) {
  SurfaceBelow below(world);
  size_t i = 0;
  ground_.clear();
  bearing.points.assign(points_.size(), {});
  for (size_t f = 0; f < model->legs.size(); f++) {
    Foot& foot = feet_[f];
    // Steps are measured from where the motion has the foot: who stands on one does not climb the next.
    const Vec3 by = Vec3{displaced.x, displaced.y, height_} + footwork_.offset(f);
    foot.lift = -1e300;
    for (size_t n = 0; n < model->legs[f].sole.size(); n++, i++) {
      const Surface s = below.find(poses, points_[i] + by, tune::kStepUp, tune::kDeep);
      ground_.push_back(s.found ? s.height + world.settings.clearance + tune::kSoleGap : -1e300);
      if (!s.found) continue;
      bearing.points[i] = {{0, 0, s.height}, s.shape, 1};
      foot.grounded = true;
      foot.lift = std::max(foot.lift, ground_.back() - points_[i].z);
    }
    rested_[f] = rests_[f] > tune::kAtRestShare ? rested_[f] + dt : 0;
    foot.rests = footwork_.steps(f) ? 0 : rests_[f];
  }
}

// The lift that skin needs which rests on something, or presses on it: seen from where contacts hold the
// person up.
void Footing::find_skin(const CollisionWorld& world, Poses& poses, Vec3 displaced) {
  SurfaceBelow below(world);
  skin_lift_ = -1e300;
  const Vec3 by{displaced.x, displaced.y, height_ + std::max(0.0, displaced.z)};
  const size_t soles = points_.size() - model->skin.size();
  for (size_t n = 0; n < model->skin.size(); n++) {
    const size_t i = soles + n;
    if (speed_[i] > tune::kMoves || model->skin[n].facing(kin_).z > -tune::kFaces) continue;
    const Vec3 x = points_[i] + by;
    const Surface s = below.find(poses, x, tune::kPressedIn, tune::kCarries);
    if (!s.found) continue;
    bearing.points[i] = {{0, 0, s.height}, s.shape, 1};
    skin_lift_ = std::max(skin_lift_, s.height + world.settings.clearance - points_[i].z);
  }
}

// False: nothing rests, the height stays.
bool Footing::wanted_height(double& height) const {
  if (sits()) {
    height = skin_lift_;
    return true;
  }
  // As high as one foot has it, no higher than the other leg reaches down.
  double highest = -1e300, most = 1e300;
  for (size_t f = 0; f < feet_.size(); f++) {
    const Foot& foot = feet_[f];
    if (!foot.grounded || (drags_ ? foot.low : rests_[f]) < tune::kAtRestShare) continue;
    if (!drags_ && foot.lift < height_ - tune::kFar && rested_[f] < tune::kRestTime) continue;
    highest = std::max(highest, foot.lift);
    most = std::min(most, foot.lift + model->legs[f].slack(tilts_ ? tilted_ : kin_, footwork_.offset(f)));
  }
  if (highest == -1e300) return false;
  height = std::min(highest, most);
  return true;
}

void Footing::move_height(double dt, double gravity) {
  double to = height_;
  if (!wanted_height(to)) {
    rising_ = 0;
    return;
  }
  const bool near = to > height_ - tune::kFloats && to < height_ + tolerated(height_);
  if (near && std::fabs(rising_) < tune::kAtRest) {
    rising_ = 0;
    return;
  }
  const double rate = tune::kHeightRate;
  const double pull = rate * rate * (to - height_) - 2 * rate * rising_;
  rising_ += dt * std::clamp(pull, -gravity, tune::kRise * gravity);
  height_ += dt * rising_;
  if (std::fabs(height_ - to) < tune::kAtHeight && std::fabs(rising_) < tune::kAtRest)
    height_ = to, rising_ = 0;
}

// The least height at which nothing is in static geometry that is over it when displaced by `by`.
double Footing::least_height(const CollisionWorld& world, Vec3 by) const {
  SurfaceBelow below(world);
  double least = -1e300;
  auto look = [&](Vec3 x) {
    const Surface s = below.find_static(x + by, tune::kNotSunk, tune::kDeep);
    if (s.found) least = std::max(least, s.height + world.settings.clearance - x.z);
  };
  const size_t soles = points_.size() - model->skin.size();
  for (size_t n = 0; n < model->skin.size(); n++) look(points_[soles + n]);
  for (const SkinPoint& p : model->hands) look(p.position(kin_));
  return least;
}

// After the height has gone down from `from`: no further than nothing sinks into the ground.
void Footing::come_down(const CollisionWorld& world, Vec3 displaced, double from, double dt) {
  if (height_ >= from) return;
  const double least = std::min(from, least_height(world, {displaced.x, displaced.y, from}));
  if (height_ >= least) return;
  height_ = least;
  rising_ = dt > 0 ? (height_ - from) / dt : 0;
}

// How far a foot is to be lifted beyond the person's height.
double Footing::wanted_lift(size_t leg, double dt) {
  const Foot& foot = feet_[leg];
  const double rests = rests_[leg];
  double lift = lift_[leg], up = 0;
  if (foot.grounded) {
    up = foot.lift - height_;
    // The lowest foot of a dance on sliding feet carries, and does not pass over the ground.
    const double carries = drags_ ? std::max(rests, foot.low) : rests;
    const double swings = (1 - carries) * tune::kSwingGap;
    if (up > -swings) up += swings;
    const bool far =
        sits() ? up < -tune::kHangs : up < -tune::kFar && rested_[leg] < tune::kRestTime;
    if (lift == 0 && up < tolerated(height_)) up = std::min(up, 0.0);
    if (up < tune::kAtHeight) up = far ? 0 : rests * std::min(0.0, up + tune::kFloats);
  }
  double& sinking = sinking_[leg];
  if (up > lift) {
    sinking = 0;
    lift = std::min(up, lift + tune::kLift * dt);
  } else {
    // Implicit: no step is too long.
    const double h = dt * tune::kLowerRate;
    sinking = (sinking + h * tune::kLowerRate * (up - lift)) / ((1 + h) * (1 + h));
    lift += dt * sinking;
  }
  return std::fabs(lift) < tune::kAtHeight ? 0 : lift;
}

// Can a foot be put down at an offset? All of its sole is over ground that is no stair away.
bool Footing::lands(SurfaceBelow& below, Poses& poses, size_t leg, Vec3 offset, double turn,
                    Vec3 displaced) const {
  const Leg& its = model->legs[leg];
  const Vec3 ankle = kin_.xpos[its.ankle];
  const Mat3 by = to_matrix(exp_quat({0, 0, turn}));
  const Vec3 whole = Vec3{displaced.x, displaced.y, height_ + lift_[leg]} + offset;
  for (const SkinPoint& p : its.sole) {
    const Vec3 x = ankle + by * (p.position(kin_) - ankle) + whole;
    if (!below.find(poses, x, tune::kLandsUp, tune::kLandsDown).found) return false;
  }
  return true;
}

// The feet keep their places while the body goes beside its motion, or step.
void Footing::move_feet(const CollisionWorld& world, Poses& poses, const Frame& frame) {
  std::vector<Footwork::Foot> feet(feet_.size());
  const Quat turns = heading_ * conjugate(heading_before_);
  const Vec3 root = kin_.xpos[model->legs[0].root];
  Vec3 slid = frame.displaced - displaced_;
  slid.z = 0;
  if (norm(slid) < tune::kNoWay) slid = {};
  for (size_t f = 0; f < feet.size(); f++) {
    feet[f].rests = rests_[f];
    feet[f].rested = rested_[f];
    feet[f].grounded = feet_[f].grounded;
    const double above = height_ + lift_[f] + left_up_[f] - feet_[f].lift;
    feet[f].stands = feet_[f].grounded && rests_[f] > tune::kAtRestShare && above < tune::kStands;
    feet[f].slid = slid;
    feet[f].held = held_[f];
    if (placed_known_) {
      const Vec3 missed = poses.kin.xpos[model->legs[f].ankle] - placed_[f];
      feet[f].missed = {missed.x, missed.y, 0};
      feet[f].stands &= std::fabs(missed.z) < tune::kStopped;
    }
    if (turns.z == 0) continue;
    const Vec3 arm = kin_.xpos[model->legs[f].ankle] - root;
    const Vec3 carried = arm - to_matrix(conjugate(turns)) * arm;
    feet[f].slid += Vec3{carried.x, carried.y, 0};
    feet[f].turned = log_quat(turns).z;
  }
  SurfaceBelow below(world);
  footwork_.frame(feet, !sits() && !flight_.flies(), frame.dt,
                  [&](size_t leg, Vec3 offset, double turn) {
                    return lands(below, poses, leg, offset, turn, frame.displaced);
                  });
}

// After the heights are known: what is on the ground at the end of the frame.
void Footing::find_state() {
  over_ground_ = on_ground_ = sits();
  for (size_t f = 0; f < feet_.size(); f++) {
    over_ground_ |= feet_[f].grounded;
    on_ground_ |= feet_[f].grounded && feet_[f].lift > height_ + lift_[f] - tune::kOnGround;
    Foot& foot = feet_[f];
    const bool near = foot.lift > height_ + lift_[f] - tune::kBears;
    foot.bears = foot.grounded && near && foot.rests > 0;
  }
}

// Which points carry the person where it is put: what rests, near a surface. After the heights are known.
void Footing::find_bearing(const Model& m, const CollisionWorld& world, Vec3 displaced) {
  const auto carries = [&](size_t i, Vec3 by, double rests) {
    BearingPoint& p = bearing.points[i];
    if (p.carries == 0) return;
    const Vec3 x = points_[i] + by;
    const double gap = x.z - p.at.z - world.settings.clearance;
    p.at = {x.x, x.y, p.at.z};
    p.carries = rests * fades(speed_[i], tune::kRests, tune::kMoves) *
                fades(gap, tune::kPresses, tune::kPressesNot);
    if (p.shape < 0) return;
    const int body = world.shapes[p.shape].body;
    if (m.pushed_dof(body) < 0 || own_[body]) p.shape = -1;
  };
  size_t i = 0;
  const Vec3 whole{displaced.x, displaced.y, height_ + std::max(0.0, displaced.z)};
  for (size_t f = 0; f < feet_.size(); f++)
    for (size_t n = 0; n < model->legs[f].sole.size(); n++, i++)
      carries(i, whole + footwork_.offset(f) + Vec3{0, 0, lift_[f] + footwork_.raised(f)},
              low_[i]);
  for (; i < points_.size(); i++) carries(i, whole, 1);
  Vec3 centre;
  double mass = 0;
  for (int b = 1; b < m.nbody; b++) {
    if (!own_[b]) continue;
    centre += m.mass[b] * (kin_.xpos[b] + kin_.xmat[b] * m.ipos[b]);
    mass += m.mass[b];
  }
  bearing.aim((1 / mass) * centre + whole);
}

void Footing::apply(int root_qpos, double* qpos) {
  corrected_ = height_ != 0;
  placed_known_ = true;
  qpos[root_qpos + 2] += height_;
  for (size_t f = 0; f < model->legs.size(); f++) {
    const Leg::Place to = place(f);
    const Vec3 from = kin_.xpos[model->legs[f].ankle];
    placed_[f] = to.ankle + displaced_;
    const bool turned = foot_turns_[f] || norm2(left_turn_[f]) > 0;
    const bool moved = to.ankle.x != from.x || to.ankle.y != from.y || to.ankle.z != from.z;
    if (!moved && !turned && !tilts_) continue;
    const Vec3 reached = model->legs[f].move(tilts_ ? tilted_ : kin_, to, qpos);
    const Vec3 made = reached - from;
    placed_[f] = reached + displaced_;
    footwork_.reached(f, made);
    lift_[f] = made.z - footwork_.raised(f) - left_up_[f];
    corrected_ = true;
  }
}

// Joints turn at constant rates between two targets, so that a foot that rolls off its toes sags on its
// way, by millimetres. Lifts feet that would be under the ground half-way; true if there are any.
bool Footing::clear_between(const Model& m, int root_qpos, const double* from, const double* to) {
  half_.assign(to, to + m.nq);
  double* q = &half_[root_qpos];
  for (int i = 0; i < 3; i++) q[i] = 0.5 * (from[i] + q[i]);
  for (int b = 1; b < m.nbody; b++) {
    if (!own_[b]) continue;
    const int at = m.jnt_qpos[m.jnt_first[b]] + (m.parent[b] == 0 ? 3 : 0);
    const Quat begin = load4(from + at - root_qpos), end = load4(to + at);
    Quat half = begin * exp_quat(0.5 * log_quat(conjugate(begin) * end));
    if (m.parent[b] == 0)
      half = exp_quat(0.5 * (log_quat(turned_before_) + log_quat(turned_))) * half;
    store4(&half_[at], normalized(half));
  }
  between_.resize(m);
  between_.update(m, half_.data(), own_.data());
  bool any = false;
  size_t i = 0;
  for (size_t f = 0; f < model->legs.size(); f++) {
    double sags = 0;
    for (const SkinPoint& p : model->legs[f].sole)
      sags = std::max(sags, ground_[i++] - p.position(between_).z);
    if (sags < tune::kSags) continue;
    lift_[f] += std::min(2 * sags, tune::kMostSag);
    any = true;
  }
  return any;
}

void Footing::clear() {
  height_ = rising_ = 0;
  flight_ = {};
  started_ = corrected_ = placed_known_ = over_ground_ = false;
  displaced_ = {};
  turned_ = heading_ = {};
  tilts_ = false;
  bearing.reset();
  way.clear();
  lift_.assign(model->legs.size(), 0);
  footwork_.clear(model->legs.size());
  placed_.assign(model->legs.size(), {});
  left_up_.assign(model->legs.size(), 0);
  left_turn_.assign(model->legs.size(), {});
  rests_.assign(model->legs.size(), 0);
  held_.assign(model->legs.size(), 0);
  foot_turn_.assign(model->legs.size(), {});
  foot_turns_.assign(model->legs.size(), 0);
  rested_.assign(model->legs.size(), 0);
  sinking_.assign(model->legs.size(), 0);
}

void Footing::start(const Model& m, const CollisionWorld& world, Poses& poses, int root_qpos,
                    double* qpos) {
  if (!on()) return;
  clear();
  read(m, qpos, {});
  find_feet(world, poses, {}, 0);
  find_skin(world, poses, {});
  double height = 0;
  if (!wanted_height(height) || std::fabs(height) > tune::kStartShift) return;
  if (height < tolerated(height_) && height > -tune::kFloats) height = 0;
  height_ = height;
  come_down(world, {}, 0, 0);
  for (size_t f = 0; f < feet_.size(); f++) {
    const double up = wanted_lift(f, 1);
    if (std::fabs(up) < tune::kStartShift) lift_[f] = up;
  }
  apply(root_qpos, qpos);
}

double Footing::ground() const {
  double height = -1e300;
  for (double z : ground_) height = std::max(height, z);
  return height;
}

bool Footing::bears(int toes) const {
  for (size_t f = 0; f < feet_.size(); f++)
    if (model->legs[f].toes == toes) return feet_[f].bears;
  return false;
}

void Footing::frame(const Model& m, const CollisionWorld& world, Poses& poses, int root_qpos,
                    const Frame& frame, double* target) {
  turn(over_ground_ ? frame.turned : Quat{});
  read(m, target, frame);
  find_feet(world, poses, frame.displaced, frame.dt);
  find_skin(world, poses, frame.displaced);
  const double from = height_;
  move_height(frame.dt, frame.gravity);
  come_down(world, frame.displaced, from, frame.dt);
  for (size_t f = 0; f < feet_.size(); f++) lift_[f] = wanted_lift(f, frame.dt);
  move_feet(world, poses, frame);
  find_left(poses, frame.dt);
  displaced_ = frame.displaced;
  find_state();
  find_bearing(m, world, frame.displaced);
  asked_.assign(target, target + m.nq);
  apply(root_qpos, target);
  if (!corrected_ || !clear_between(m, root_qpos, frame.from, target)) return;
  std::copy(asked_.begin(), asked_.end(), target);
  apply(root_qpos, target);
}

// Begins with its length: whoever takes the state over may have no footing, or another.
void Footing::save(std::vector<double>& out) const {
  const size_t at = out.size();
  out.push_back(0);
  if (!on()) return;
  out.insert(out.end(), {height_, rising_, started_ ? 1.0 : 0.0, corrected_ ? 1.0 : 0.0,
                         placed_known_ ? 1.0 : 0.0, over_ground_ ? 1.0 : 0.0});
  flight_.save(out);
  footwork_.save(out);
  for (const auto* v : {&left_turn_, &placed_})
    for (Vec3 x : *v) out.insert(out.end(), {x.x, x.y, x.z});
  for (const auto* v : {&lift_, &rested_, &sinking_, &left_up_}) out.insert(out.end(), v->begin(), v->end());
  out.insert(out.end(), {displaced_.x, displaced_.y, displaced_.z, turned_.w, turned_.x, turned_.y,
                         turned_.z});
  for (size_t i = 0; i < before_.size(); i++)
    out.insert(out.end(), {before_[i].x, before_[i].y, before_[i].z, speed_[i]});
  bearing.save(before_.size(), out);
  way.save(out);
  out.push_back(ground());
  out[at] = (double)(out.size() - at - 1);
}

const double* Footing::load(const double* in) {
  const double* end = in + 1 + (size_t)*in;
  const bool any = *in++ > 0;
  if (!on()) return end;
  clear();
  if (!any) return end;
  height_ = in[0], rising_ = in[1], started_ = in[2] != 0, corrected_ = in[3] != 0;
  placed_known_ = in[4] != 0, over_ground_ = in[5] != 0;
  in = flight_.load(in + 6);
  in = footwork_.load(in, model->legs.size());
  for (auto* v : {&left_turn_, &placed_})
    for (Vec3& x : *v) x = load3(in), in += 3;
  for (auto* v : {&lift_, &rested_, &sinking_, &left_up_}) {
    v->assign(in, in + model->legs.size());
    in += model->legs.size();
  }
  displaced_ = load3(in), turn(load4(in + 3)), in += 7;
  size_t points = model->skin.size();
  for (const Leg& leg : model->legs) points += leg.sole.size();
  before_.resize(points);
  speed_.resize(points);
  for (size_t i = 0; i < points; i++, in += 4) before_[i] = load3(in), speed_[i] = in[3];
  in = bearing.restore(points, in);
  in = way.load(in);
  ground_.assign(1, *in);
  return end;
}

}  // namespace hp
