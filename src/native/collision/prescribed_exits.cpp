#include "collision/prescribed_exits.h"

#include "geometry/separation.h"
#include "tuning.h"

namespace hp {

namespace tune = tuning::collision;

void PrescribedExits::forget() {
  known_ = false;
  states_.erase_if([&](const PairId& c) { return world_.shapes[c.shape].person >= 0; });
}

std::vector<PrescribedExits::Pair> PrescribedExits::overlaps(
    Poses& start, const std::vector<BroadPhasePair>& pairs) const {
  std::vector<Pair> found;
  for (const BroadPhasePair& e : pairs) {
    if (e.other_shape < 0 || world_.shapes[e.shape].person < 0 || !world_.takes_part(e)) continue;
    const PosedShape &a = world_.place(start, e.shape), &b = world_.place(start, e.other_shape);
    if (a.box().meets(b.box()) && separate(a, b, 0, false).dist < 0)
      found.push_back({e.shape, e.other_shape, -1});
  }
  return found;
}

// All pairs of the first one's object whose shapes are connected with its shape in the skeleton.
void PrescribedExits::take_group(const Model& m, std::vector<Pair>& all, size_t first,
                                 std::vector<size_t>& group) const {
  auto body = [&](int shape) { return world_.shapes[shape].body; };
  auto neighbours = [&](int a, int b) { return a == b || m.parent[a] == b || m.parent[b] == a; };
  group.assign(1, first);
  all[first].group = (int)first;
  for (size_t k = 0; k < group.size(); k++)
    for (size_t i = first + 1; i < all.size(); i++) {
      const Pair& known = all[group[k]];
      if (all[i].group >= 0 || body(all[i].other) != body(known.other) ||
          !neighbours(body(all[i].shape), body(known.shape)))
        continue;
      all[i].group = (int)first;
      group.push_back(i);
    }
}

Vec3 PrescribedExits::least_deep_direction(Poses& start, const std::vector<Pair>& all,
                                           const std::vector<size_t>& group) const {
  std::vector<Vec3> directions;
  for (size_t i : group) {
    const PosedShape &a = world_.place(start, all[i].shape), &b = world_.place(start, all[i].other);
    directions.push_back(separate(a, b).n);
    for (Vec3 n : b.hull->normals) directions.push_back(-(b.R * n));
  }
  for (int k = 0; k < 27; k++) {
    const Vec3 n{(double)(k % 3 - 1), (double)(k / 3 % 3 - 1), (double)(k / 9 - 1)};
    if (k != 13) directions.push_back((1 / norm(n)) * n);
  }
  Vec3 best;
  double least = -1e300;
  for (Vec3 n : directions) {
    double dist = 0;
    for (size_t i : group) {
      const PosedShape &a = world_.place(start, all[i].shape),
                       &b = world_.place(start, all[i].other);
      dist = std::min(dist, separate_along(a, b, n).dist);
      if (dist <= least) break;
    }
    if (dist > least) least = dist, best = n;
  }
  return best;
}

void PrescribedExits::update(const Model& m, Poses& start,
                             const std::vector<BroadPhasePair>& pairs) {
  if (known_) return;
  known_ = true;
  std::vector<Pair> all = overlaps(start, pairs);
  struct Found {
    int object;
    Vec3 exit;
  };
  std::vector<Found> found;
  squeezed.assign(m.nbody, 0);
  std::vector<size_t> group;
  for (size_t first = 0; first < all.size(); first++) {
    if (all[first].group >= 0) continue;
    take_group(m, all, first, group);
    const Vec3 exit = least_deep_direction(start, all, group);
    const int object = world_.shapes[all[first].other].body;
    for (const Found& f : found)
      if (f.object == object && dot(f.exit, exit) < tune::kOpposedExits) squeezed[object] = 1;
    found.push_back({object, exit});
    for (size_t i : group) {
      states_[PairId{all[i].shape, -1, all[i].other}] = {world_.settings.clearance, true, exit};
    }
  }
}

}  // namespace hp
