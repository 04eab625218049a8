#include "stepping/contact_cache.h"

#include "stepping/data.h"
#include "tuning.h"

namespace hp {

namespace tune = tuning::stepping;

void ContactCache::begin_attempt() {
  for (CachedContact& w : contacts_) w.used = false;
}

bool ContactCache::warm_start(const System& system, State& state,
                              const std::vector<ContactCandidate>& candidates, Contact& c) {
  const int shape = candidates[c.pair].shape;
  const CollisionShape& m = system.world.shapes[shape];
  double best = tune::kWarmRadius2;
  CachedContact* found = nullptr;
  for (CachedContact& w : contacts_) {
    if (w.used || w.key != c.key || dot(w.normal, c.n) < tune::kWarmNormal) continue;
    const double d =
        norm2(state.pose.position(m, system.world.place(state.pose, shape), w.point) - c.position);
    if (d < best) best = d, found = &w;
  }
  if (!found) return false;
  c.impulse = found->impulse;
  if (c.spread == 0) c.spread = found->spread;
  found->used = true;
  return true;
}

void ContactCache::forget(const System& system, const std::vector<char>& forget) {
  auto forgotten = [&](const CachedContact& w) {
    const PairId pair = pair_of_key(w.key);
    return forget[system.tree(pair.shape)] ||
           (pair.other_shape >= 0 && forget[system.tree(pair.other_shape)]);
  };
  contacts_.erase(std::remove_if(contacts_.begin(), contacts_.end(), forgotten), contacts_.end());
}

void ContactCache::drop(const System& system, const std::vector<char>& renewed) {
  const auto out_of_date = [&](const CachedContact& w) {
    return renewed[system.tree(pair_of_key(w.key).shape)] != 0;
  };
  next_.erase(std::remove_if(next_.begin(), next_.end(), out_of_date), next_.end());
}

void ContactCache::keep(const System& system, State& state, const ContactCandidate& k,
                        const Contact& c) {
  const World& world = system.world;
  auto material = [&](int shape, const Material& gap, Vec3 x) {
    if (world.shapes[shape].skin) return gap;  // a vertex, or what moves with it
    return state.pose.material(world.shapes[shape], world.place(state.pose, shape), x);
  };
  // Of two shapes: the points that face each other, `dist` apart about the one that the impulse
  // acts on.
  const Vec3 half = k.other_shape >= 0 ? 0.5 * c.dist * c.n : Vec3{};
  Material other;
  if (k.other_shape >= 0) other = material(k.other_shape, c.gap_b, c.position - half);
  next_.push_back({c.key, c.feature, material(k.shape, c.gap_a, c.position + half), other, c.n,
                   c.impulse, c.spread, false});
}

void ContactCache::save(std::vector<double>& out) const {
  out.push_back((double)contacts_.size());
  for (const CachedContact& w : contacts_) {
    out.insert(out.end(), {(double)(w.key >> 32), (double)(w.key & 0xffffffff), (double)w.feature,
                           (double)w.point.vertex, (double)w.other.vertex, w.spread});
    for (Vec3 v : {w.point.local, w.other.local, w.normal, w.impulse})
      out.insert(out.end(), {v.x, v.y, v.z});
  }
}

const double* ContactCache::load(const double* in) {
  contacts_.clear();
  for (int n = (int)*in++; n > 0; n--, in += 18)
    contacts_.push_back({((int64_t)in[0] << 32) | (int64_t)in[1],
                         (int)in[2],
                         {(int)in[3], load3(in + 6)},
                         {(int)in[4], load3(in + 9)},
                         load3(in + 12),
                         load3(in + 15),
                         in[5],
                         false});
  return in;
}

void ContactCache::adopt(const ContactCache& old, const std::vector<int>& now) {
  contacts_.clear();
  for (CachedContact w : old.contacts_) {
    PairId pair = pair_of_key(w.key);
    pair.shape = now[pair.shape];
    if (pair.other_shape >= 0) pair.other_shape = now[pair.other_shape];
    if (pair.shape < 0 || (pair.other_static < 0 && pair.other_shape < 0)) continue;
    w.key = pair_key(pair);
    contacts_.push_back(w);
  }
}

}  // namespace hp
