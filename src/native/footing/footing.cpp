#include "footing/footing.h"

#include "tuning.h"

namespace hp {

namespace tune = tuning::footing;

namespace {

// 1 up to `low`, 0 from `high` on.
double fades(double x, double low, double high) {
  return std::clamp((high - x) / (high - low), 0.0, 1.0);
}

// Soles may be this much nearer to the ground than they are put [m]: who has not been lifted and stands
// clear of it, by as little as contact needs, keeps the motion's bits.
double tolerated(double height) {
  return tune::kAtHeight + (height == 0 ? tune::kSoleGap - tune::kLeastSoleGap : 0);
}

}  // namespace

// Where the points of the reference are in the pose `qpos`, and how fast they got there in `time` of its
// own; if none passed, as before.
void Footing::read(const Model& m, const double* qpos, double time, double gravity) {
  kin_.resize(m);
  own_.assign(m.nbody, 0);
  const int root = m.root[model->legs[0].hip];
  for (int b = 1; b < m.nbody; b++) own_[b] = m.root[b] == root;
  kin_.update(m, qpos, own_.data());
  points_.clear();
  for (const Leg& leg : model->legs)
    for (const SkinPoint& p : leg.sole) points_.push_back(p.position(kin_));
  for (const SkinPoint& p : model->skin) points_.push_back(p.position(kin_));
  speed_.resize(points_.size());
  if (!started_) speed_.assign(points_.size(), 0);
  if (started_ && time > tune::kNoTime)
    for (size_t i = 0; i < points_.size(); i++) speed_[i] = norm(points_[i] - before_[i]) / time;
  before_ = points_;
  started_ = true;
  double lowest = 1e300;
  for (const Vec3& p : points_) lowest = std::min(lowest, p.z);
  flight_.see(kin_.xpos[root].z, lowest, time, gravity);
}

void Footing::find_feet(const CollisionWorld& world, Poses& poses, Vec3 displaced, double dt) {
  SurfaceBelow below(world);
  size_t i = 0;
  feet_.assign(model->legs.size(), {});
  ground_.clear();
  bearing.points.assign(points_.size(), {});
  for (size_t f = 0; f < model->legs.size(); f++) {
    Foot& foot = feet_[f];
    // Steps are measured from where the motion has the foot: who stands on one does not climb the next.
    const Vec3 by{displaced.x + shift_[f].x, displaced.y + shift_[f].y, height_};
    foot.lift = -1e300;
    for (size_t n = 0; n < model->legs[f].sole.size(); n++, i++) {
      const double low = fades(points_[i].z - flight_.lowest(), tune::kLow, tune::kHigh);
      foot.low = std::max(foot.low, low);
      foot.rests = std::max(foot.rests, low * fades(speed_[i], tune::kRests, tune::kMoves));
      const Surface s = below.find(poses, points_[i] + by, tune::kStepUp, tune::kDeep);
      ground_.push_back(s.found ? s.height + world.settings.clearance + tune::kSoleGap : -1e300);
      if (!s.found) continue;
      bearing.points[i] = {{0, 0, s.height}, s.shape, 1};
      foot.grounded = true;
      foot.lift = std::max(foot.lift, ground_.back() - points_[i].z);
    }
    rested_[f] = foot.rests > 0.5 ? rested_[f] + dt : 0;
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
  bool falls = !flight_.flies();
  for (const Foot& foot : feet_) falls &= foot.rests <= 0.5;
  for (size_t f = 0; f < feet_.size(); f++) {
    const Foot& foot = feet_[f];
    if (!foot.grounded || (falls ? foot.low : foot.rests) < 0.5) continue;
    if (!falls && foot.lift < height_ - tune::kFar && rested_[f] < tune::kRestTime) continue;
    highest = std::max(highest, foot.lift);
    most = std::min(most, foot.lift + model->legs[f].slack(kin_));
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

// Where a foot is to be put beyond the person's height.
Vec3 Footing::wanted_shift(size_t leg, Vec3 displaced, double dt) {
  const Foot& foot = feet_[leg];
  Vec3 shift = shift_[leg];
  double up = 0;
  if (foot.grounded) {
    up = foot.lift - height_;
    const double swings = (1 - foot.rests) * tune::kSwingGap;
    if (up > -swings) up += swings;
    const bool far =
        sits() ? up < -tune::kHangs : up < -tune::kFar && rested_[leg] < tune::kRestTime;
    if (shift.z == 0 && up < tolerated(height_)) up = std::min(up, 0.0);
    if (up < tune::kAtHeight) up = far ? 0 : foot.rests * std::min(0.0, up + tune::kFloats);
  }
  double& sinking = sinking_[leg];
  if (up > shift.z) {
    sinking = 0;
    shift.z = std::min(up, shift.z + tune::kLift * dt);
  } else {
    // Implicit: no step is too long.
    const double h = dt * tune::kLowerRate;
    sinking = (sinking + h * tune::kLowerRate * (up - shift.z)) / ((1 + h) * (1 + h));
    shift.z += dt * sinking;
  }
  if (std::fabs(shift.z) < tune::kAtHeight) shift.z = 0;
  Vec3 behind{shift.x, shift.y, 0};
  if (foot.rests > 0.5 && foot.grounded) {
    const Vec3 slid = displaced - displaced_;
    behind -= Vec3{slid.x, slid.y, 0};
  } else {
    const double size = norm(behind), less = std::max(0.0, size - tune::kGiveUp * dt);
    behind = size > 0 ? (less / size) * behind : behind;
  }
  const double size = norm(behind);
  if (size > tune::kMostBehind) behind = (tune::kMostBehind / size) * behind;
  return {behind.x, behind.y, shift.z};
}

// After the heights are known: what is on the ground at the end of the frame.
void Footing::find_state() {
  over_ground_ = on_ground_ = sits();
  at_rest_ = true;
  for (size_t f = 0; f < feet_.size(); f++) {
    over_ground_ |= feet_[f].grounded;
    on_ground_ |= feet_[f].grounded && feet_[f].lift > height_ + shift_[f].z - tune::kOnGround;
    at_rest_ &= feet_[f].rests > 0.5;
    Foot& foot = feet_[f];
    const bool near = foot.lift > height_ + shift_[f].z - tune::kBears;
    foot.bears = foot.grounded && near && foot.rests > 0;
  }
  at_rest_ |= sits();
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
      carries(i, whole + shift_[f],
              fades(points_[i].z - flight_.lowest(), tune::kLow, tune::kHigh));
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
  qpos[root_qpos + 2] += height_;
  for (size_t f = 0; f < model->legs.size(); f++) {
    if (shift_[f].x == 0 && shift_[f].y == 0 && shift_[f].z == 0) continue;
    shift_[f] = model->legs[f].move(kin_, shift_[f], qpos);
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
    store4(&half_[at], normalized(begin * exp_quat(0.5 * log_quat(conjugate(begin) * end))));
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
    shift_[f].z += std::min(2 * sags, tune::kMostSag);
    any = true;
  }
  return any;
}

void Footing::clear() {
  height_ = rising_ = 0;
  flight_ = {};
  started_ = corrected_ = at_rest_ = false;
  displaced_ = {};
  bearing.reset();
  shift_.assign(model->legs.size(), {});
  rested_.assign(model->legs.size(), 0);
  sinking_.assign(model->legs.size(), 0);
}

void Footing::start(const Model& m, const CollisionWorld& world, Poses& poses, int root_qpos,
                    double* qpos) {
  if (!on()) return;
  clear();
  read(m, qpos, 0, 0);
  find_feet(world, poses, {}, 0);
  find_skin(world, poses, {});
  double height = 0;
  if (!wanted_height(height) || std::fabs(height) > tune::kStartShift) return;
  if (height < tolerated(height_) && height > -tune::kFloats) height = 0;
  height_ = height;
  come_down(world, {}, 0, 0);
  for (size_t f = 0; f < feet_.size(); f++) {
    const double up = wanted_shift(f, {}, 1).z;
    if (std::fabs(up) < tune::kStartShift) shift_[f].z = up;
  }
  apply(root_qpos, qpos);
}

bool Footing::bears(int toes) const {
  for (size_t f = 0; f < feet_.size(); f++)
    if (model->legs[f].toes == toes) return feet_[f].bears;
  return false;
}

void Footing::frame(const Model& m, const CollisionWorld& world, Poses& poses, int root_qpos,
                    const Frame& frame, double* target) {
  read(m, target, frame.passed, frame.gravity);
  find_feet(world, poses, frame.displaced, frame.dt);
  find_skin(world, poses, frame.displaced);
  const double from = height_;
  move_height(frame.dt, frame.gravity);
  come_down(world, frame.displaced, from, frame.dt);
  for (size_t f = 0; f < feet_.size(); f++) shift_[f] = wanted_shift(f, frame.displaced, frame.dt);
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
                         at_rest_ ? 1.0 : 0.0});
  flight_.save(out);
  for (Vec3 v : shift_) out.insert(out.end(), {v.x, v.y, v.z});
  for (const auto* v : {&rested_, &sinking_}) out.insert(out.end(), v->begin(), v->end());
  out.insert(out.end(), {displaced_.x, displaced_.y, displaced_.z});
  for (size_t i = 0; i < before_.size(); i++)
    out.insert(out.end(), {before_[i].x, before_[i].y, before_[i].z, speed_[i]});
  bearing.save(before_.size(), out);
  out[at] = (double)(out.size() - at - 1);
}

const double* Footing::load(const double* in) {
  const double* end = in + 1 + (size_t)*in;
  const bool any = *in++ > 0;
  if (!on()) return end;
  clear();
  if (!any) return end;
  height_ = in[0], rising_ = in[1], started_ = in[2] != 0, corrected_ = in[3] != 0;
  at_rest_ = in[4] != 0;
  in = flight_.load(in + 5);
  for (Vec3& v : shift_) v = load3(in), in += 3;
  for (auto* v : {&rested_, &sinking_}) {
    v->assign(in, in + model->legs.size());
    in += model->legs.size();
  }
  displaced_ = load3(in), in += 3;
  size_t points = model->skin.size();
  for (const Leg& leg : model->legs) points += leg.sole.size();
  before_.resize(points);
  speed_.resize(points);
  for (size_t i = 0; i < points; i++, in += 4) before_[i] = load3(in), speed_[i] = in[3];
  bearing.restore(points, in);
  return end;
}

}  // namespace hp
