#include "stepping/drive.h"

#include <limits>

#include "tuning.h"

namespace hp {

namespace tune = tuning::stepping;

Drive::Drive(const Model& m, int root_body)
    : PersonDofs(m, root_body), motion(*this), effort(dof_count()) {
  for (auto* v : {&v_ref_, &deviation_, &v_drive_, &gain_}) v->assign(dof_count(), 0);
  stiffness_.assign(ball_count(), 1);
  lately_.assign(ball_count(), 0);
}

void Drive::reset(const double* target, double* qvel) {
  motion.reset(target);
  q_start_ = motion.target();
  for (auto* v : {&v_ref_, &deviation_, &v_drive_}) v->assign(dof_count(), 0);
  effort.drop();
  for (int i = 0; i < dof_count(); i++) qvel[first_dof() + i] = 0;
  std::fill(lately_.begin(), lately_.end(), 0.0);
  exact_ = true;
  carried = sits = false;
  gentle_return.stop();
}

void Drive::aim(const DriveSettings& s, const double* target, double dt, const double* qpos) {
  effort.begin_frame();
  motion.aim(s, target, dt, qpos, footing.on());
}

bool Drive::settled(const DriveSettings& s, const double* qpos) const {
  if (s.own_forces() || s.torque()) return false;
  if (exact_) return true;
  if (s.time_constant > 0)
    for (double e : deviation_)
      if (std::fabs(e) > tune::kSettledSpeed) return false;
  for (const Ball& b : balls()) {
    const Quat turn = conjugate(motion.before(b)) * load4(qpos + first_qpos() + b.qpos);
    if (norm2(Vec3{turn.x, turn.y, turn.z}) > tune::kSettledAngle * tune::kSettledAngle)
      return false;
  }
  return true;
}

void Drive::followed(bool exerts) {
  exact_ = true;
  motion.follow_all();
  if (!exerts) effort.drop();
  for (auto* v : {&deviation_, &lately_}) std::fill(v->begin(), v->end(), 0.0);
}

bool Drive::lately() const {
  for (int i = 0; i < ball_count(); i++)
    if (lately(i)) return true;
  return false;
}

namespace {

// The part of a change of velocity that leads towards the deviation `e`: there the reference comes nearer to
// the body's own velocity.
Vec3 towards(Vec3 change, Vec3 e) {
  const double size2 = norm2(change);
  return size2 > 0 ? std::clamp(dot(e, change) / size2, 0.0, 1.0) * change : Vec3{};
}

}  // namespace

// How much the root's deviation grows as a frame begins whose reference goes at another velocity than `v_ref`, that of
// the frame before, and the body keeps its momentum: all that a clock that slows down takes; and of what the way back
// to the path or round something changes, once touched, what leads towards the body's own velocity (who is held by a
// wall is not thrown back as it gives up), and what is more than feet give.
Vec3 Drive::keeps(const DriveSettings& s, Vec3 v_ref) const {
  if (s.time_constant == 0) return {};
  const Vec3 by = clock.slowed() * v_ref;
  if (!lately()) return by;
  Vec3 change = motion.beside() - (1 - clock.slowed()) * motion.beside_before();
  change.z = 0;
  const Vec3 rest = change - towards(change, load3(deviation_.data()) + by);
  const double most = tuning::footing::kFeetGive * motion.frame_length();
  return by - (change - capped(rest, most));
}

void Drive::begin_frame(const DriveSettings& s, const double* qpos, double* qvel) {
  motion.velocity(qvel);
  motion.step_through();
  exact_ = false;
  const double rate = 1 / motion.frame_length();
  const int nv = dof_count();
  const Vec3 e = load3(deviation_.data()), before = load3(qvel + first_dof()) - e;
  store3(deviation_.data(), e + keeps(s, before));
  // That of the last frame.
  for (int i = 0; i < nv; i++) gain_[i] = qvel[first_dof() + i] - deviation_[i];
  motion.reference(v_ref_.data());
  for (int i = 0; i < nv; i++) gain_[i] = motion.first() ? 0 : rate * (v_ref_[i] - gain_[i]);
  // What layers carry they also speed up: a motion that lands on them takes nothing from its fall.
  if (s.time_constant > 0)
    deviation_[2] -= footing.sinks() * footing.layers.share() * gain_[2] / rate;
  if (s.time_constant == 0) set_velocities(s, qpos + first_qpos(), qvel);
}

// Algorithm 1: the velocity that leads from the pose where the person is to the target.
void Drive::set_velocities(const DriveSettings& s, const double* q, double* qvel) {
  const double rate = 1 / motion.frame_length();
  q_start_.assign(q, q + qpos_count());
  store3(v_drive_.data(), motion.root_velocity());
  for (int i = 0; i < ball_count(); i++) {
    const Ball& b = balls()[i];
    Vec3 w = rate * rotation_between(q + b.qpos, &motion.target()[b.qpos]);
    const Vec3 asked = load3(&v_ref_[b.dof]);
    double most = s.recovery_rate + tune::kReturnPerMotion * norm(asked);
    if (s.torque()) most = std::numeric_limits<double>::infinity();
    if (gentle()) most = std::min(most, gentle_return.rate(i));
    if (norm(w - asked) > most) w = asked + capped(w - asked, most);
    store3(&v_drive_[b.dof], w);
  }
  const int set = s.torque() ? 6 : dof_count();  // torques leave the joints as they are
  for (int i = 0; i < set; i++) qvel[first_dof() + i] = v_drive_[i];
  if (s.torque()) v_ref_.assign(dof_count(), 0);  // all of a velocity is deviation
}

double DriveSettings::resistance(double lambda, double h) const {
  if (torque()) return torque_firmness(h);
  if (time_constant > 0 || own_forces()) return lambda;
  return std::max(lambda, h / tune::kLimpTime);
}

namespace {

bool is_leg(const Footing& footing, int body) {
  for (const Leg& leg : footing.model->legs)
    if (body == leg.hip || body == leg.knee || body == leg.ankle || body == leg.toes) return true;
  return false;
}

// Firmness of a ball. Legs of whom layers carry bear its weight against them. Toes of a foot that is on the ground bear on it: as light as they are, they would
// curl under the foot.
double firmness(const Drive& d, const DriveSettings& s, int ball) {
  const double lambda = d.stiffness()[ball], toes = tuning::footing::kToeFirmness;
  if (!d.footing.on() || s.time_constant == 0 || lambda == 0 || lambda >= toes) return lambda;
  const int body = d.body(ball);
  if (d.footing.has_toes(body) && d.footing.bears(body)) return toes;
  return d.footing.layers.carry() && is_leg(d.footing, body)
             ? std::max(lambda, tuning::footing::kLegFirmness)
             : lambda;
}

}  // namespace

void Drive::added_inertia(const DriveSettings& s, double h, const Inertia& inertia,
                          std::vector<double>& extra) const {
  for (int i = 1; i < ball_count(); i++) {
    const int d = ball_dof(i);
    double mean = 0;
    for (int c = 0; c < 3; c++) mean += inertia.diagonal(d + c) / 3;
    for (int c = 0; c < 3; c++) extra[d + c] = s.resistance(firmness(*this, s, i), h) * mean;
  }
}

double Drive::scale(const DriveSettings& s, double h) const {
  if (s.time_constant == 0) return 1;
  const double r = h / s.time_constant;
  return 1 + 2 * r + r * r;
}

bool Drive::free_velocity(const DriveSettings& s, int k, double h, const double* qpos,
                          const double* qvel, double* v_free, double* deviation) const {
  const double* q = qpos + first_qpos();
  double* v = v_free + first_dof();
  if (s.time_constant > 0) {
    spring_velocity(s, k, h, q, v);
    return false;
  }
  for (int i = 0; i < dof_count(); i++) v[i] = qvel[first_dof() + i];
  if (s.torque()) return torque_deviation(s, h, qpos, qvel, deviation);
  return restored_deviation(s, k, h, q, v, deviation + first_dof());
}

namespace {

// How fast a ball comes back to the motion, at most [rad/s].
double return_rate(const Drive& d, const DriveSettings& s, int ball) {
  double most = s.recovery_rate;
  if (d.gentle()) most = std::min(most, d.gentle_return.rate(ball));
  if (!d.yields.empty()) most = std::min(most, d.yields[ball]);
  return most;
}

}  // namespace

// The root's deviation over a frame, as spring_velocity() has it: in kFrameParts implicit steps.
Drive::Ahead Drive::ahead(const DriveSettings& s, const double* target, double dt,
                          const double* qpos) const {
  if (exact_) return {};
  const Ball& root = balls()[0];
  const Quat before = motion.after(root), after = load4(target + root.qpos);
  Vec3 off = log_quat(conjugate(before) * load4(qpos + first_qpos() + root.qpos)), drift;
  const bool turned = norm(off) >= tune::kSettledAngle;
  const double rate = (1 - footing.layers.rest()) * return_rate(*this, s, 0);
  if (s.time_constant == 0) {
    if (turned) off = std::max(0.0, 1 - dt * rate / norm(off)) * off;
  } else {
    const double tau = s.time_constant, h = dt / tune::kFrameParts, sc = scale(s, h);
    Vec3 v = load3(&deviation_[0]), w = load3(&deviation_[root.dof]);
    for (int k = 0; k < tune::kFrameParts; k++) {
      v = (1 / sc) * v;
      drift += h * v;
      w = (1 / sc) * (w - (h / (tau * tau)) * capped(off, 2 * tau * rate));
      off += h * w;
    }
  }
  const Quat turn = normalized(after * exp_quat(off) * conjugate(after));
  // On layers it goes on as it does.
  const double up = footing.sinks() * dt * deviation_[2];
  return {turned ? turn : Quat{}, {drift.x, drift.y, up}};
}

// v* with a time constant.
void Drive::spring_velocity(const DriveSettings& s, int k, double h, const double* q,
                            double* v) const {
  const double tau = s.time_constant, sc = scale(s, h);
  for (int i = 0; i < 3; i++) v[i] = v_ref_[i] + deviation_[i] / sc;
  // What is about to come through a layer is stopped as by hard ground.
  const bool stopped = footing.bottoms() && deviation_[2] < 0;
  if (!stopped) {
    const double keeps = elementary::exp(-tuning::footing::kLayerDamping * h);
    v[2] += footing.sinks() * (v_ref_[2] + keeps * deviation_[2] - v[2]);
  }
  for (int i = 0; i < ball_count(); i++) {
    const Ball& b = balls()[i];
    const Quat ref = motion.before(b) * exp_quat((k * h) * load3(&v_ref_[b.dof]));
    const double most = 2 * tau * return_rate(*this, s, i);
    const Vec3 xi = capped(log_quat(conjugate(ref) * load4(q + b.qpos)), most);
    const Vec3 e = load3(&deviation_[b.dof]) - (h / (tau * tau)) * xi;
    store3(v + b.dof, load3(&v_ref_[b.dof]) + (1 / sc) * e);
  }
}

// eps - h v of PJSC, and -h (v - v_drive) of what damps limp joints, each with its share.
bool Drive::restored_deviation(const DriveSettings& s, int k, double h, const double* q,
                               const double* v, double* out) const {
  bool any = false;
  for (int i = 1; i < ball_count(); i++) {
    const double total = s.resistance(stiffness_[i], h);
    if (total == 0) continue;
    const Ball& b = balls()[i];
    const Quat expected =
        load4(&q_start_[b.qpos]) * exp_quat(((k + 1) * h) * load3(&v_drive_[b.dof]));
    Vec3 way = h * load3(v + b.dof), turn = log_quat(conjugate(load4(q + b.qpos)) * expected);
    // About a half turn rounding decides which way round the log goes; it is the way it turns.
    const double angle = norm(turn);
    if (dot(turn, way) < 0 && angle > 0.5 * M_PI) turn = (1 - 2 * M_PI / angle) * turn;
    const double firm = stiffness_[i] / total;
    Vec3 eps = turn - way;
    if (firm < 1) eps = firm * eps - (1 - firm) * (way - h * load3(&v_drive_[b.dof]));
    if (norm2(eps) < tune::kLeastDeviation2) continue;
    any = true;
    store3(out + b.dof, eps);
  }
  return any;
}

void Drive::end_substep(const double* qvel, double h, const std::vector<char>& pushed) {
  for (int i = 0; i < ball_count(); i++)
    lately_[i] = pushed[body(i)] ? tune::kTouchedTime : std::max(0.0, lately_[i] - h);
  for (int i = 0; i < dof_count(); i++) deviation_[i] = qvel[first_dof() + i] - v_ref_[i];
}

void Drive::set_stiffness(const double* lambda) {
  stiffness_.assign(lambda, lambda + ball_count());
}

void Drive::unhindered(double* v) const {
  for (int i = 0; i < dof_count(); i++) v[first_dof() + i] = v_ref_[i] + deviation_[i];
}

void Drive::deviation_change(const double* qvel, double* change) const {
  const int first = first_dof();
  for (int i = 0; i < dof_count(); i++)
    change[first + i] = qvel[first + i] - v_ref_[i] - deviation_[i];
}

void Drive::reference(double* v) const { std::copy(v_ref_.begin(), v_ref_.end(), v + first_dof()); }

void Drive::reference_change(double* a) const {
  std::copy(gain_.begin(), gain_.end(), a + first_dof());
}

void Drive::save(std::vector<double>& out) const {
  for (const auto* v : {&motion.target(), &v_ref_, &deviation_, &stiffness_, &lately_})
    out.insert(out.end(), v->begin(), v->end());
  out.insert(out.end(), {(exact_ ? 1.0 : 0.0) + (motion.fresh() ? 2.0 : 0.0) +
                             (carried ? 4.0 : 0.0) + (sits ? 8.0 : 0.0),
                         gentle_return.left(), motion.beside().x, motion.beside().y, motion.eager});
  footing.save(out);
  clock.save(out);
}

const double* Drive::load(const double* in) {
  const double* target = in;
  in += qpos_count();
  for (auto* v : {&v_ref_, &deviation_, &stiffness_, &lately_}) {
    std::copy(in, in + v->size(), v->begin());
    in += v->size();
  }
  const int flags = (int)*in++;
  exact_ = (flags & 1) != 0;
  const double left = *in++;
  motion.restore(target, (flags & 2) != 0, {in[0], in[1], 0});
  const double eager = in[2];
  in += 3;
  carried = (flags & 4) != 0;
  sits = (flags & 8) != 0;
  q_start_ = motion.target();
  gentle_return.restore(left);
  in = footing.load(in);
  clock.reset(*this, target);
  in = clock.load(*this, in);
  motion.eager = eager;
  return in;
}

}  // namespace hp
