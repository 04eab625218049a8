#include "collision/friction_places.h"

#include <algorithm>
#include <cmath>

#include "geometry/patch_spread.h"
#include "tuning.h"

namespace hp {

namespace tune = tuning::collision;

// People hold and stand by the points themselves (the header); a ball touches in one point: others are where
// it touched in the passes before.
bool FrictionPlaces::may_spread(const CollisionWorld& world, const Contact& c) {
  const auto alone = [&](int shape) {
    if (shape < 0) return false;
    const CollisionShape& s = world.shapes[shape];
    return s.person >= 0 || (s.hull.vertices.size() == 1 && s.hull.rim == 0);
  };
  const PairId pair = pair_of_key(c.key);
  return c.friction > 0 && !alone(pair.shape) && !alone(pair.other_shape);
}

// The contacts of the patch of contacts[first]; false if that is alone.
bool FrictionPlaces::find_patch(const CollisionWorld& world, std::vector<Contact>& contacts,
                                size_t first) {
  const Vec3 n = contacts[first].n;
  const auto meets = [&](const Contact& a, const Contact& b) {
    const Vec3 way = a.position - b.position;
    return std::fabs(way.x) <= tune::kOnePlace && norm2(way) <= tune::kOnePlace * tune::kOnePlace &&
           world.shapes[pair_of_key(a.key).shape].body ==
               world.shapes[pair_of_key(b.key).shape].body &&
           may_spread(world, a);
  };
  patch_.assign(1, first);
  pairs_.assign(1, contacts[first].pair);
  keys_.assign(1, contacts[first].key);
  contacts[first].placed = true;
  in_.assign(contacts.size(), 0);
  in_[first] = 1;
  for (size_t next = 0; next < patch_.size(); next++)
    for (size_t k = 0; k < contacts.size(); k++) {
      Contact& c = contacts[k];
      const Contact& o = contacts[patch_[next]];
      if (in_[k] || (c.pair != o.pair && !meets(c, o)) || dot(c.n, n) <= tune::kOnePatch) continue;
      in_[k] = 1;
      c.placed = true;
      patch_.push_back(k);
      if (std::find(pairs_.begin(), pairs_.end(), c.pair) != pairs_.end()) continue;
      pairs_.push_back(c.pair);
      keys_.push_back(c.key);
    }
  return patch_.size() > 1;
}

// By the impulses of the last solve; false if there are none.
bool FrictionPlaces::find_centre_of_solved(const std::vector<Contact>& contacts, size_t solved) {
  double sum = 0;
  centre_ = {};
  for (const size_t k : patch_) {
    if (k >= solved) continue;
    const double p = std::max(0.0, dot(contacts[k].impulse, contacts[k].n));
    sum += p;
    centre_ += p * contacts[k].position;
  }
  if (sum > 0) centre_ = (1 / sum) * centre_;
  return sum > 0;
}

// By those of the substep before; false if there are none.
bool FrictionPlaces::find_centre_of_cached(const CollisionWorld& world, Poses& start,
                                           const std::vector<CachedContact>& cached,
                                           const std::vector<Contact>& contacts) {
  const Vec3 n = contacts[patch_[0]].n;
  double sum = 0;
  centre_ = {};
  for (const CachedContact& w : cached) {
    if (std::find(keys_.begin(), keys_.end(), w.key) == keys_.end() ||
        dot(w.normal, n) < tune::kOnePatch)
      continue;
    const double p = std::max(0.0, dot(w.impulse, w.normal));
    if (p == 0) continue;
    const int shape = pair_of_key(w.key).shape;
    sum += p;
    centre_ += p * start.position(world.shapes[shape], world.place(start, shape), w.point);
  }
  if (sum > 0) centre_ = (1 / sum) * centre_;
  return sum > 0;
}

void FrictionPlaces::find_centre_of_loads(const std::vector<Contact>& contacts) {
  double sum = 0;
  centre_ = {};
  for (double& w : load_) sum += w = std::max(0.0, w);
  for (size_t k = 0; k < patch_.size(); k++)
    centre_ +=
        (sum > 0 ? load_[k] / sum : 1.0 / (double)patch_.size()) * contacts[patch_[k]].position;
}

double FrictionPlaces::find_spread(const CollisionWorld& world, Poses& start,
                                   const std::vector<ContactCandidate>& candidates,
                                   const std::vector<Contact>& contacts) {
  if (patch_.size() == 2) return PatchSpread::kEdge;
  size_t known = 0;
  double spread = 0;
  for (const size_t k : patch_)
    if (contacts[k].spread > 0) spread = contacts[k].spread, known++;
  // Three corners of a face that carried something are a face.
  if (known >= 3) return spread;
  PatchSpread out(contacts[patch_[0]].n);
  for (const int pair : pairs_) {
    const ContactCandidate& c = candidates[pair];
    const PosedShape* other = nullptr;
    if (c.other_shape >= 0)
      other = &world.place(start, c.other_shape);
    else if (world.statics[c.other_static].kind == Static::Kind::Hull)
      other = &world.statics[c.other_static].posed;
    out.add_face(world.place(start, c.shape), other, tune::kFaceThickness);
  }
  return out.spread();
}

void FrictionPlaces::draw_in(std::vector<Contact>& contacts, double spread) const {
  for (const size_t k : patch_) {
    Contact& point = contacts[k];
    const Vec3 out = point.position - centre_;
    point.spread = spread;
    point.inward = (spread - 1) * (out - dot(out, point.n) * point.n);
  }
}

}  // namespace hp
