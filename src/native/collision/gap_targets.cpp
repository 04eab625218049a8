#include "collision/gap_targets.h"

#include <algorithm>

#include "tuning.h"

namespace hp {

namespace tune = tuning::collision;

void GapTargets::set(ContactCandidate& c, double h) {
  const ContactSettings& settings = world_.settings;
  double clear = c.overlap >= 0 ? tune::kLeastGap : settings.clearance;
  PairState* state = states_.find(c);
  const bool kept = state && state->kept;
  if (state && c.overlap < 0) {
    if (c.dist >= clear)
      states_.erase(c);
    else
      clear = std::min(clear, state->clearance);
  }
  if (c.dist >= clear)
    c.target = clear;
  else if (c.dist >= 0)
    c.target = c.dist + std::min(clear - c.dist, tune::kRegainSpeed * h);
  else if (kept)
    c.target = c.dist;
  else
    c.target = c.dist + std::min(forced_.pace_of(c) * settings.depenetration_speed * h, -c.dist);
  if (c.dist <= 0) {
    const bool own = c.other_shape >= 0 && world_.may_touch_itself(c.shape, c.other_shape);
    c.hard = c.dist -
             (own ? tune::kDeeperShare * settings.depenetration_speed * h : tune::kOverlapRounding);
    return;
  }
  c.hard = 0.5 * std::min(c.dist, tune::kLeastGap);
  if (clear < 2 * tune::kWearFloor) return;  // a pair that rests nearer than that is in no danger
  c.hard = std::min(std::max(c.hard, tune::kWearFloor),
                    std::max(c.dist - 2 * settings.tolerance, std::min(c.dist, tune::kLastFloor)));
}

void GapTargets::add(ContactCandidate& c, const Plane& p, double h,
                     std::vector<ContactCandidate>& out) {
  c.n = p.n;
  c.offset = p.offset;
  c.dist = p.dist;
  c.triangle = p.triangle;
  set(c, h);
  out.push_back(c);
}

}  // namespace hp
