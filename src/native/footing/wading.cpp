#include "footing/wading.h"

#include <algorithm>

#include "tuning.h"

namespace hp {

namespace tune = tuning::footing;

void Wading::clear(size_t legs) {
  feet_.assign(legs, {});
  hindered_ = 0;
  leave();
}

void Wading::leave() {
  walks_ = 0;
  least_ = -1e300;
  known_ = false;
}

void Wading::pushed(bool aside, double dt) {
  hindered_ = aside ? tuning::stepping::kTouchedTime : std::max(0.0, hindered_ - dt);
}

void Wading::frame(const FootingModel& model, const Stance& stance, const Footwork& work,
                   const Underfoot& under, Vec3 centre, double dt) {
  std::vector<BearingPoint> points;
  std::vector<double> share;
  size_t i = 0, resting = 0;
  bool any = false;
  for (size_t f = 0; f < feet_.size(); f++)
    resting += under.feet[f].grounded && stance.feet[f].rests > tune::kAtRestShare;
  for (size_t f = 0; f < feet_.size(); f++) {
    // Of who dances on sliding feet, lands or hops, what is low carries.
    const double rests = resting > 0 ? stance.feet[f].rests : stance.feet[f].low;
    const double carries = under.feet[f].grounded ? rests : 0;
    any |= carries > tune::kAtRestShare;
    for (size_t n = 0; n < model.legs[f].sole.size(); n++, i++) {
      const double slow = resting > 0 ? fades(stance.speed[i], tune::kRests, tune::kMoves) : 1;
      points.push_back({stance.points[i] + work.offset(f), -1, carries * stance.low[i] * slow});
    }
  }
  const bool moves = known_ && dt > tune::kNoTime;
  const Vec3 speed = moves ? (1 / dt) * (centre - centre_) : Vec3{};
  centre_ = centre;
  walks_ =
      resting == 0 || resting == feet_.size() ? walks_ * elementary::exp(-dt / tune::kWadeTime) : 1;
  if (any) {
    spread_weight(points, centre + tune::kWadeAhead * speed, share);
    // Implicit: no step is too long.
    const double h = dt * tune::kWadeRate;
    i = 0;
    for (size_t f = 0; f < model.legs.size(); f++) {
      Foot& foot = feet_[f];
      double wanted = 0;
      for (size_t n = 0; n < model.legs[f].sole.size(); n++) wanted += share[i++];
      if (!known_) foot = {wanted, 0};
      foot.rate = (foot.rate + h * tune::kWadeRate * (wanted - foot.share)) / ((1 + h) * (1 + h));
      foot.share += dt * foot.rate;
    }
    known_ = true;
  }
  find_least(under);
}

double Wading::lift(const Stance& stance, size_t leg, double sunk, double rises) const {
  double most = 0;
  for (const Foot& foot : feet_) most = std::max(most, foot.share);
  const double whole = most + walks_ * (1 - most);
  const double left = known_ && whole > 0 ? std::max(0.0, 1 - feet_[leg].share / whole) : 1;
  const Stance::Foot& foot = stance.feet[leg];
  return sunk * left + (1 - foot.rests) * foot.high +
         foot.rests * (1 - left) * tune::kWadeGives * rises;
}

void Wading::find_least(const Underfoot& under) {
  size_t most = 0;
  for (size_t f = 1; f < feet_.size(); f++)
    if (feet_[f].share > feet_[most].share) most = f;
  const bool any = known_ && !feet_.empty() && under.feet[most].grounded;
  least_ = any ? under.feet[most].least : -1e300;
}

void Wading::save(std::vector<double>& out) const {
  for (const Foot& foot : feet_) out.insert(out.end(), {foot.share, foot.rate});
  out.insert(out.end(),
             {walks_, known_ ? 1.0 : 0.0, centre_.x, centre_.y, centre_.z, hindered_, least_});
}

const double* Wading::load(const double* in) {
  for (Foot& foot : feet_) foot = {in[0], in[1]}, in += 2;
  walks_ = in[0], known_ = in[1] != 0;
  centre_ = load3(in + 2);
  hindered_ = in[5], least_ = in[6];
  return in + 7;
}

}  // namespace hp
