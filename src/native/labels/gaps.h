// How far hulls of a skin are from what a thing of a scene touches by, for judging contacts.
// Nothing here changes a simulation.
#pragma once
#include <memory>
#include <vector>

#include "geometry/bvh.h"
#include "geometry/convex.h"

namespace hp {

struct GapThing {
  struct HalfSpace {
    Vec3 normal;
    double offset;
  };
  std::vector<HalfSpace> half_spaces;
  std::vector<Convex> hulls;
  std::vector<std::shared_ptr<const TriangleTree>> meshes;

  // Distance of a hull in the world, the thing at a pose; what is over `range` may be any number over it.
  // Half-spaces and meshes are in the world already.
  double gap(const PosedShape& hull, const Mat3& turn, Vec3 position, double range) const;
};

}  // namespace hp
