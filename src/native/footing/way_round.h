// A way round: how somebody who is off the path comes back to it around static geometry.
//
// The shortest way along the ground (A*, Hart, Nilsson, Raphael 1968) on a grid of kCell around the person, which a
// vertical capsule, from the height of a stair to that of the chest, has to pass with room for a body. Places are
// probed only as the search comes to them. Narrow ones cost more. Of the way found the person goes to
// the farthest point that it sees. Where there is no way it goes to the place that is nearest.
#pragma once
#include <vector>

#include "collision/collision_world.h"

namespace hp {

class WayRound {
 public:
  // Where to go next from `from` on the way to `to`, as time `dt` [s] passes; ground is at height
  // `ground` [m]. Heights of the points do not matter. `from`
  // itself if it can get no nearer.
  Vec3 next(const CollisionWorld& world, Vec3 from, Vec3 to, double ground, double dt);
  // Is something in between?
  bool on() const { return on_; }
  void clear();

  void save(std::vector<double>& out) const;
  const double* load(const double* in);

 private:
  void find(const CollisionWorld& world, Vec3 from, Vec3 to, double ground);

  bool on_ = false;
  std::vector<Vec3> way_;  // what is left of it
  Vec3 to_;                // where it leads
  double age_ = 0;         // since it was found [s]
};

}  // namespace hp
