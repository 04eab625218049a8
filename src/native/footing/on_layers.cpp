#include "footing/on_layers.h"

#include <algorithm>

#include "tuning.h"

namespace hp {

namespace tune = tuning::footing;

// Feet among what stands on hard ground; none where anything else does too.
OnLayers::Feet OnLayers::find_feet(const std::vector<BearingPoint>& points, size_t soles,
                                   double legs, Vec3 centre) {
  Feet feet;
  double all = 0;
  for (size_t i = 0; i < points.size(); i++) {
    const BearingPoint& p = points[i];
    if (p.carries <= 0) continue;
    if (i >= soles) return {};
    all += p.carries;
    feet.centre += p.carries * p.at;
  }
  if (all == 0) return {};
  feet.on = true, feet.legs = legs;
  feet.centre = (1 / all) * feet.centre;
  const double x = feet.centre.x - centre.x, y = feet.centre.y - centre.y;
  const double way = std::max(elementary::hypot(x, y), tune::kShortestLever);
  for (const BearingPoint& p : points)
    if (p.carries > 0)
      feet.breadth =
          std::max(feet.breadth,
                   std::fabs((p.at.y - feet.centre.y) * x - (p.at.x - feet.centre.x) * y) / way);
  return feet;
}

void OnLayers::move(double speed, bool sits, double dt) {
  const double goal = sits ? std::clamp((tune::kMovesOnLayers - speed) /
                                            (tune::kMovesOnLayers - tune::kRestsOnLayers),
                                        0.0, 1.0)
                           : 0;
  rest_ += (1 - elementary::exp(-dt / tune::kComesToRest)) * (goal - rest_);
}

void OnLayers::aim(const std::vector<BearingPoint>& others, size_t soles, double legs, Vec3 centre,
                   bool sits) {
  stands_ = !sits && std::any_of(others.begin(), others.end(),
                                 [](const BearingPoint& p) { return p.carries > 0; });
  if (!carry_) return;
  feet_ = find_feet(others, soles, legs, centre);
  std::vector<BearingPoint> points;
  double all = 0;
  for (const BearingPoint& p : others) {
    if (p.carries <= 0) continue;
    points.push_back(p);
    all += p.carries;
  }
  if (all > 0 && !feet_.on) rest_ = 0;
  target_ = 1;
  if (points.empty()) return;
  if (stands_ && pressed_ < tune::kBrushes) {  // a hand is on a cushion
    carry_ = false;
    share_ = target_ = 0;
    return;
  }
  const double own = std::clamp(std::max(pressed_, sits ? tune::kSeatShare : 0.0),
                                tune::kLeastLayerShare, 1 - tune::kLeastLayerShare);
  points.push_back({centre_, -1, all * own / (1 - own)});
  std::vector<double> share;
  spread_weight(points, centre, share);
  target_ = share.back();
}

void OnLayers::advance(double h) {
  if (!carry_) return;
  const double goal = target_ + (feet_.on ? rest_ * (1 - feet_share_ - target_) : 0);
  share_ += (1 - elementary::exp(-h / tune::kLayerShareTime)) * (goal - share_);
}

void OnLayers::pressed(double weights, Vec3 centre, double dt) {
  const bool before = carry_;
  carry_ = weights > (stands_ ? tune::kBrushes : tune::kCarryFrom);
  if (!carry_) {
    feet_ = {};
    share_ = target_ = pressed_ = rest_ = 0;
    return;
  }
  const double part = before ? 1 - elementary::exp(-dt / tune::kLayerCentreTime) : 1;
  pressed_ += part * (weights - pressed_);
  centre_ += part * (centre - centre_);
}

void OnLayers::reset() {
  carry_ = stands_ = false;
  share_ = target_ = pressed_ = rest_ = feet_share_ = 0;
  centre_ = {}, feet_ = {};
}

void OnLayers::save(std::vector<double>& out) const {
  out.insert(out.end(), {carry_ ? 1.0 : 0.0, share_, target_, pressed_, centre_.x, centre_.y,
                         centre_.z, rest_, feet_share_, stands_ ? 1.0 : 0.0, feet_.on ? 1.0 : 0.0});
}

const double* OnLayers::restore(const double* in) {
  carry_ = in[0] != 0;
  share_ = in[1], target_ = in[2], pressed_ = in[3];
  centre_ = load3(in + 4);
  rest_ = in[7], feet_share_ = in[8];
  stands_ = in[9] != 0, feet_.on = in[10] != 0;
  return in + 11;
}

}  // namespace hp
