// Which contacts of the substep before are used again (contact_points.h).
#include "collision/contact_points.h"
#include "tuning.h"

namespace hp {

namespace tune = tuning::collision;

bool ContactPoints::recalls(const ContactCandidate& c) const {
  if (c.overlap >= 0 || c.other_shape >= 0) return c.overlap < 0 && world_.handles(c);
  return world_.shapes[c.shape].person >= 0 && world_.shapes[c.shape].hull.rim == 0;
}

bool ContactPoints::recall(Poses& start, const std::vector<ContactCandidate>& candidates,
                           std::vector<CachedContact>& cached) const {
  bool any = false;
  for (CachedContact& w : cached) {
    w.candidate = -1;
    double best = pair_of_key(w.key).other_static >= 0 ? tune::kCachedNormal : -2;
    for (size_t i = 0; i < candidates.size(); i++) {
      if (pair_key(candidates[i]) != w.key || !recalls(candidates[i]) ||
          candidates[i].known != Known::Plane || candidates[i].soft >= 0)
        continue;
      const double alike = dot(w.normal, candidates[i].n);
      if (alike > best) best = alike, w.candidate = (int)i;
    }
    if (w.candidate >= 0 && !stays(start, candidates[w.candidate], w)) w.candidate = -1;
    any |= w.candidate >= 0;
  }
  return any;
}

// A vertex whose gap to a static is hardly more than is asked, or that carried an impulse.
bool ContactPoints::stays(Poses& start, const ContactCandidate& c, const CachedContact& w) const {
  if (c.other_static < 0) return true;
  const PosedShape& a = world_.place(start, c.shape);
  if (w.feature < 0 || w.feature >= a.points().n) return false;
  if (norm2(w.impulse) > 0) return true;
  const double gap = dot(c.n, a.points().at(w.feature)) - a.hull->radius - c.offset;
  return gap < c.target + tune::kStaysNear;
}

}  // namespace hp
