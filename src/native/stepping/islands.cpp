#include "stepping/islands.h"

#include <numeric>

namespace hp {

void Islands::find(const System& system, const std::vector<ContactCandidate>& candidates) {
  island_.resize(system.model.nbody);
  std::iota(island_.begin(), island_.end(), 0);
  auto root = [&](int b) {
    while (island_[b] != b) b = island_[b] = island_[island_[b]];
    return b;
  };
  const std::vector<char>& active = system.world.active;
  for (const ContactCandidate& c : candidates) {
    if (c.other_shape < 0) continue;
    const int a = system.tree(c.shape), b = system.tree(c.other_shape);
    if (active[a] && active[b]) island_[root(a)] = root(b);
  }
  for (int b = 0; b < system.model.nbody; b++) island_[b] = root(b);
}

}  // namespace hp
