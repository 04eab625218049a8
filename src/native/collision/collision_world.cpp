#include "collision/collision_world.h"

namespace hp {

void CollisionWorld::set_self_pairs(const std::vector<std::pair<int, int>>& pairs) {
  self_pairs_.assign(pairs.empty() ? 0 : shapes.size() * shapes.size(), 0);
  for (const auto& [i, j] : pairs)
    self_pairs_[i * shapes.size() + j] = self_pairs_[j * shapes.size() + i] = 1;
}

bool CollisionWorld::may_touch(const Model& m, int a, int b) const {
  const CollisionShape &A = shapes[a], &B = shapes[b];
  if (m.root[A.body] == m.root[B.body] && !may_touch_itself(a, b)) return false;
  return !pairing(A.name, B.name).ignore;
}

bool CollisionWorld::takes_part(const BroadPhasePair& e) const {
  const int a = shapes[e.shape].body;
  if (e.other_shape < 0) return active[a] && !asleep[a];
  const int b = shapes[e.other_shape].body;
  if (asleep[a] && asleep[b]) return false;
  return (active[a] && (active[b] || standing[b])) || (active[b] && standing[a]);
}

}  // namespace hp
