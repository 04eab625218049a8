#include "footing/stance.h"

#include "tuning.h"

namespace hp {

namespace tune = tuning::footing;

void Stance::clear(size_t legs) {
  flight_ = {};
  started_ = tilts_ = drags = false;
  turned_ = heading_ = {};
  root_before_ = aside_ = {};
  feet.assign(legs, {});
}

// How the body is turned off the motion: about the vertical, and besides.
void Stance::turn(Quat turned) {
  turned_before_ = turned_, heading_before_ = heading_;
  turned_ = turned, heading_ = {};
  const double size = std::sqrt(turned.w * turned.w + turned.z * turned.z);
  if (turned.z != 0 && size > tune::kUpsideDown)
    heading_ = {turned.w / size, 0, 0, turned.z / size};
  tilts_ = turned.x != 0 || turned.y != 0;
}

void Stance::turn_root(const Model& m, const double* qpos, Quat by,
                       std::vector<double>& out) const {
  out.assign(qpos, qpos + m.nq);
  double* q = &out[m.jnt_qpos[m.jnt_first[root_]] + 3];
  if (by.w != 1) store4(q, normalized(by * load4(q)));
}

void Stance::pose(const Model& m, const double* qpos) {
  own_.assign(m.nbody, 0);
  for (int b = 1; b < m.nbody; b++) own_[b] = m.root[b] == root_;
  const auto update = [&](Kinematics& k, Quat by) {
    k.resize(m);
    turn_root(m, qpos, by, turned_qpos_);
    k.update(m, turned_qpos_.data(), own_.data());
  };
  update(kin, heading_);
  if (tilts_) update(tilted_, turned_);
}

// Where the points are, and how fast they got there in the reference; if no time passed, as before.
void Stance::find_points(const FootingModel& model, const View& view) {
  points.clear();
  for (const Leg& leg : model.legs)
    for (const SkinPoint& p : leg.sole) points.push_back(p.position(kin));
  for (const SkinPoint& p : model.skin) points.push_back(p.position(kin));
  own_points_ = points;
  if (heading_.z != 0) {
    const Vec3 at = kin.xpos[root_];
    const Mat3 back = to_matrix(conjugate(heading_));
    for (Vec3& p : own_points_) p = at + back * (p - at);
  }
  const size_t count = points.size();
  speed.resize(count);
  loses_.assign(count, 0);
  if (!started_) speed.assign(count, 0), velocity_.assign(count, {});
  if (started_ && view.dt > tune::kNoTime)
    for (size_t i = 0; i < count; i++) {
      const Vec3 was = velocity_[i];
      const Vec3 is = velocity_[i] = (1 / view.dt) * (own_points_[i] - before_[i]);
      speed[i] = norm(is);
      const double size2 = is.x * is.x + is.y * is.y;
      const double lost = is.x * (was.x - is.x) + is.y * (was.y - is.y);
      if (size2 > 0) loses_[i] = std::max(0.0, lost / (size2 * view.dt));
    }
  before_ = own_points_;
  aside_ = {};
  if (started_ && heading_.z != 0) {
    const Vec3 way = kin.xpos[root_] - root_before_;
    aside_ = way - to_matrix(heading_) * way;
  }
  root_before_ = kin.xpos[root_];
  started_ = true;
  double lowest = 1e300;
  for (const Vec3& p : own_points_) lowest = std::min(lowest, p.z);
  bool rests = false;
  for (size_t i = 0; i < own_points_.size(); i++)
    rests |= speed[i] < tune::kRests && own_points_[i].z < lowest + tune::kLow;
  flight_.see(kin.xpos[root_].z, lowest, rests, view.passed, view.gravity);
}

Vec3 Stance::goes(size_t point, double time) const {
  const Vec3 v = to_matrix(heading_) * velocity_[point];
  const double loses = loses_[point];
  if (loses * time > 1) time = 1 / loses;  // then it stands
  const double lasts = time - 0.5 * loses * time * time;
  return {lasts * v.x, lasts * v.y, 0};
}

// What rests, and how feet are turned: by how they have been left behind, and level for who waits.
void Stance::find_rest(const FootingModel& model, const Footwork& work, double waits, double dt) {
  size_t i = 0;
  low.clear();
  drags = !flight_.flies();
  for (size_t f = 0; f < feet.size(); f++) {
    const Leg& leg = model.legs[f];
    Foot& foot = feet[f];
    const size_t end = i + leg.sole.size();
    foot.low = foot.rests = 0;
    foot.high = 1e300;
    for (; i < end; i++) {
      foot.high = std::min(foot.high, own_points_[i].z - flight_.lowest());
      const double is_low = fades(own_points_[i].z - flight_.lowest(), tune::kLow, tune::kHigh);
      foot.low = std::max(foot.low, is_low);
      foot.rests = std::max(foot.rests, is_low * fades(speed[i], tune::kRests, tune::kMoves));
      low.push_back(std::max(is_low, waits));
    }
    foot.rests = std::max(foot.rests, waits);
    foot.rested = foot.rests > tune::kAtRestShare ? foot.rested + dt : 0;
    foot.held = waits > tune::kAtRestShare;
    drags &= foot.rests <= tune::kAtRestShare;
    const double angle = work.turn(f);
    foot.turns = waits > 0 || angle != 0;
    if (!foot.turns) continue;
    foot.turn = exp_quat({0, 0, angle});
    const Vec3 up = kin.xmat[leg.ankle].col(1), axis = cross(up, {0, 0, 1});
    const double sine = norm(axis), tilt = elementary::atan2(sine, up.z);
    if (sine > 0) foot.turn = foot.turn * exp_quat((waits * tilt / sine) * axis);
    const Vec3 ankle = kin.xpos[leg.ankle];
    const Mat3 by = to_matrix(foot.turn);
    for (size_t k = end - leg.sole.size(); k < end; k++)
      points[k] = ankle + by * (points[k] - ankle);
  }
}

void Stance::read(const Model& m, const FootingModel& model, const Footwork& work, const View& view,
                  const double* qpos) {
  root_ = m.root[model.legs[0].hip];
  turn(view.turned);
  pose(m, qpos);
  find_points(model, view);
  find_rest(model, work, flight_.flies() ? 0 : view.waits, view.dt);
}

Vec3 Stance::centre_of_mass(const Model& m) const {
  Vec3 centre;
  double mass = 0;
  for (int b = 1; b < m.nbody; b++) {
    if (!own_[b]) continue;
    centre += m.mass[b] * (kin.xpos[b] + kin.xmat[b] * m.ipos[b]);
    mass += m.mass[b];
  }
  return (1 / mass) * centre;
}

void Stance::save(std::vector<double>& out) const {
  flight_.save(out);
  out.insert(out.end(), {started_ ? 1.0 : 0.0, turned_.w, turned_.x, turned_.y, turned_.z,
                         root_before_.x, root_before_.y, root_before_.z});
  for (const Foot& foot : feet) out.push_back(foot.rested);
  for (size_t i = 0; i < before_.size(); i++)
    for (Vec3 v : {before_[i], velocity_[i]}) out.insert(out.end(), {v.x, v.y, v.z});
}

const double* Stance::load(const double* in, const FootingModel& model) {
  clear(model.legs.size());
  in = flight_.load(in);
  started_ = in[0] != 0;
  turn(load4(in + 1));
  root_before_ = load3(in + 5);
  in += 8;
  for (Foot& foot : feet) foot.rested = *in++;
  size_t count = model.skin.size();
  for (const Leg& leg : model.legs) count += leg.sole.size();
  before_.resize(count);
  velocity_.resize(count);
  speed.resize(count);
  for (size_t i = 0; i < count; i++, in += 6) {
    before_[i] = load3(in), velocity_[i] = load3(in + 3);
    speed[i] = norm(velocity_[i]);
  }
  return in;
}

}  // namespace hp
