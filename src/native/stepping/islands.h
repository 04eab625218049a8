// Islands: trees that contact candidates connect (as in Bullet and Jolt). What one island does
// changes nothing in another: clearances are given up, and steps shortened, island by island.
//
// Union-find over the trees' root bodies. Only active trees connect: inactive ones stand where they
// are, like static geometry.
#pragma once
#include <vector>

#include "stepping/system.h"

namespace hp {

class Islands {
 public:
  void find(const System& system, const std::vector<ContactCandidate>& candidates);
  // The island of the tree with this root body; islands are named by one of their root bodies.
  int of_tree(int root) const { return island_[root]; }
  // The island of a candidate: that of its active side.
  int of(const System& system, const ContactCandidate& c) const {
    const int a = system.tree(c.shape);
    return island_[system.world.active[a] ? a : system.tree(c.other_shape)];
  }
  const std::vector<int>& all() const { return island_; }

 private:
  std::vector<int> island_;  // per body
};

}  // namespace hp
