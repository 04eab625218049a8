#include "collision/self_depenetration.h"

#include "collision/least_overlap.h"
#include "tuning.h"

namespace hp {

namespace tune = tuning::collision;

void SelfDepenetration::reset(const Model& m, Poses& start) {
  waited_ = 0, depth_ = 1e300;
  if (world_.self_contact()) choose_directions(m, start);
}

void SelfDepenetration::update(const Model& m, Poses& start) {
  if (++waited_ < tune::kStuckPatience) return;
  waited_ = 0;
  double depth = 0;
  for (const Pair& p : overlapping(m)) {
    const Vec3 n = start.kin.xmat[p.reference] * p.state->exit;
    const PosedShape &a = world_.place(start, p.shape), &b = world_.place(start, p.other);
    depth += std::max(0.0, b.highest(n) - a.lowest(n));
  }
  if (depth > 0 && depth > tune::kEnoughProgress * depth_) choose_directions(m, start);
  depth_ = depth > 0 ? depth : 1e300;
}

std::vector<SelfDepenetration::Pair> SelfDepenetration::overlapping(const Model& m) {
  std::vector<Pair> all;
  states_.for_each([&](const PairId& c, PairState& state) {
    if (!state.overlapping || c.other_shape < 0 || !world_.may_touch_itself(c.shape, c.other_shape))
      return;
    all.push_back({&state, c.shape, c.other_shape, reference_body(m, c), (int)all.size(), 1});
  });
  return all;
}

// The pairs that are neighbours of the first on both sides, and of those, and so on.
std::vector<size_t> SelfDepenetration::take_group(const Model& m, std::vector<Pair>& all,
                                                  size_t first) const {
  auto neighbours = [&](int i, int j) {
    const int a = world_.shapes[i].body, b = world_.shapes[j].body;
    return a == b || m.parent[a] == b || m.parent[b] == a || m.parent[a] == m.parent[b];
  };
  std::vector<size_t> group{first};
  for (size_t k = 0; k < group.size(); k++)
    for (size_t l = first + 1; l < all.size(); l++) {
      const Pair p = all[group[k]];
      Pair& q = all[l];
      if (q.group != (int)l) continue;
      const bool same = neighbours(p.shape, q.shape) && neighbours(p.other, q.other);
      if (!same && !(neighbours(p.shape, q.other) && neighbours(p.other, q.shape))) continue;
      q.group = (int)first, q.sign = same ? p.sign : -p.sign;
      group.push_back(l);
    }
  return group;
}

void SelfDepenetration::choose_directions(const Model& m, Poses& start) {
  std::vector<Pair> all = overlapping(m);
  for (size_t first = 0; first < all.size(); first++) {
    if (all[first].group != (int)first) continue;
    const std::vector<size_t> group = take_group(m, all, first);
    std::vector<Vec3> guesses;
    for (size_t k : group)
      guesses.push_back(all[k].sign * (world_.place(start, all[k].shape).center -
                                       world_.place(start, all[k].other).center));
    auto least_apart = [&](Vec3 n, double most) {
      double least = 1e300;
      for (size_t k : group) {
        if (least < most) break;
        const Vec3 d = all[k].sign * n;
        least = std::min(least, world_.place(start, all[k].shape).lowest(d) -
                                    world_.place(start, all[k].other).highest(d));
      }
      return least;
    };
    const Vec3 n = best_direction(least_apart, guesses);
    for (size_t k : group)
      all[k].state->exit = mul_t(start.kin.xmat[all[k].reference], all[k].sign * n);
  }
}

void SelfDepenetration::save(std::vector<double>& out) const {
  if (world_.self_contact()) out.insert(out.end(), {(double)waited_, depth_});
}

const double* SelfDepenetration::load(const double* in) {
  if (!world_.self_contact()) return in;
  waited_ = (int)*in++;
  depth_ = *in++;
  return in;
}

}  // namespace hp
