#include "stepping/reference_clock.h"

#include "tuning.h"

namespace hp {

namespace footing_tune = tuning::footing;

void ReferenceClock::reset(const PersonDofs& dofs, const double* target) {
  reached_.assign(target, target + dofs.qpos_count());
  ahead_.clear();
  waited_ = passed_ = untouched_ = slowed_ = 0;
  rate_ = eager_ = 1;
  impatient_ = false;
}

// The rate of the clock in the next dt, and at which share of its pace the person goes back to its path.
void ReferenceClock::decide(Vec3 displaced, bool touched, bool stands, bool round, double dt) {
  const Asked& next = ahead_.front();
  Vec3 way = load3(next.qpos.data()) - load3(reached_.data());
  way.z = 0;
  const double length = norm(way), speed = length / next.time;
  const double behind = speed > footing_tune::kStill ? -dot(displaced, way) / length : 0;
  const double most = rate_ + footing_tune::kSpeedUp * dt,
               most_eager = eager_ + footing_tune::kSpeedUp * dt;
  untouched_ = touched ? 0 : untouched_ + dt;
  rate_ = std::min(1.0, most), eager_ = std::min(1.0, most_eager);
  if (behind < footing_tune::kBehind) impatient_ = false, waited_ = 0;
  if (behind >= footing_tune::kBehind && round) impatient_ = true;
  const double late = lag();
  if (behind < footing_tune::kBehind && !touched && late > footing_tune::kLate)
    rate_ = std::min(footing_tune::kCatchUp, most);
  if (behind < footing_tune::kBehind || (!touched && waited_ == 0) || impatient_) return;
  const double share = std::max(
      0.0, (footing_tune::kBlocked - behind) / (footing_tune::kBlocked - footing_tune::kBehind));
  waited_ += (1 - share) * dt;
  impatient_ = waited_ > footing_tune::kPatience;
  if (untouched_ < footing_tune::kTriesAgain) eager_ = std::min(share, most_eager);
  rate_ = std::min(stands ? share : std::max(share, footing_tune::kSlowest), most);
  rate_ = std::max(rate_, std::min(1.0, late - (footing_tune::kLatest - 1)));
}

void ReferenceClock::move_on(const PersonDofs& dofs, double time) {
  while (!ahead_.empty() && time > 0) {
    Asked& next = ahead_.front();
    if (next.time <= time * (1 + footing_tune::kSameTime)) {
      time -= next.time;
      reached_.swap(next.qpos);
      ahead_.pop_front();
      continue;
    }
    const double share = time / next.time;
    for (int i = 0; i < 3; i++) reached_[i] += share * (next.qpos[i] - reached_[i]);
    for (const PersonDofs::Ball& b : dofs.balls()) {
      const Quat from = load4(&reached_[b.qpos]);
      const Vec3 turn = log_quat(conjugate(from) * load4(&next.qpos[b.qpos]));
      store4(&reached_[b.qpos], normalized(from * exp_quat(share * turn)));
    }
    next.time -= time;
    time = 0;
  }
}

const double* ReferenceClock::advance(const PersonDofs& dofs, const double* target, double dt,
                                      Vec3 displaced, bool touched, bool stands, bool round) {
  passed_ = dt;
  slowed_ = 0;
  if (!on) return target;
  ahead_.push_back({{target, target + dofs.qpos_count()}, dt});
  const double before = rate_;
  decide(displaced, touched, stands, round, dt);
  if (rate_ < before) slowed_ = 1 - rate_ / before;
  passed_ = dt * rate_;
  move_on(dofs, passed_);
  return reached_.data();
}

double ReferenceClock::lag() const {
  double lag = 0;
  for (const Asked& a : ahead_) lag += a.time;
  return lag;
}

void ReferenceClock::save(std::vector<double>& out) const {
  out.push_back(on ? 1 : 0);
  if (!on) return;
  out.insert(out.end(), reached_.begin(), reached_.end());
  out.insert(out.end(), {(double)ahead_.size(), waited_, passed_, untouched_, rate_, eager_,
                         impatient_ ? 1.0 : 0.0});
  for (const Asked& a : ahead_) {
    out.push_back(a.time);
    out.insert(out.end(), a.qpos.begin(), a.qpos.end());
  }
}

const double* ReferenceClock::load(const PersonDofs& dofs, const double* in) {
  const bool was_on = *in++ != 0;
  if (!was_on) return in;
  reset(dofs, in);
  in += dofs.qpos_count();
  const size_t count = (size_t)in[0];
  waited_ = in[1], passed_ = in[2], untouched_ = in[3];
  rate_ = in[4], eager_ = in[5], impatient_ = in[6] != 0;
  in += 7;
  for (size_t i = 0; i < count; i++, in += dofs.qpos_count() + 1)
    ahead_.push_back({{in + 1, in + 1 + dofs.qpos_count()}, in[0]});
  return in;
}

}  // namespace hp
