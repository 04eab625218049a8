#include "footing/on_layers.h"

#include <algorithm>

#include "tuning.h"

namespace hp {

namespace tune = tuning::footing;

void OnLayers::aim(const std::vector<BearingPoint>& others, Vec3 centre, bool sits) {
  if (!carry_) return;
  std::vector<BearingPoint> points;
  double all = 0;
  for (const BearingPoint& p : others) {
    if (p.carries <= 0) continue;
    points.push_back(p);
    all += p.carries;
  }
  target_ = 1;
  if (points.empty()) return;
  if (!sits && pressed_ < tune::kBrushes) {  // it stands, and a hand is on a cushion
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
  share_ += (1 - elementary::exp(-h / tune::kLayerShareTime)) * (target_ - share_);
}

void OnLayers::pressed(double weights, Vec3 centre, double dt) {
  const bool before = carry_;
  carry_ = weights > tune::kCarryFrom;
  if (!carry_) {
    share_ = target_ = pressed_ = 0;
    return;
  }
  const double part = before ? 1 - elementary::exp(-dt / tune::kLayerCentreTime) : 1;
  pressed_ += part * (weights - pressed_);
  centre_ += part * (centre - centre_);
}

void OnLayers::reset() {
  carry_ = false;
  share_ = target_ = pressed_ = 0;
  centre_ = {};
}

void OnLayers::save(std::vector<double>& out) const {
  out.insert(out.end(),
             {carry_ ? 1.0 : 0.0, share_, target_, pressed_, centre_.x, centre_.y, centre_.z});
}

const double* OnLayers::restore(const double* in) {
  carry_ = in[0] != 0;
  share_ = in[1], target_ = in[2], pressed_ = in[3];
  centre_ = load3(in + 4);
  return in + 7;
}

}  // namespace hp
