#include "labels/gaps.h"

#include <limits>

#include "geometry/separation.h"

namespace hp {

double GapThing::gap(const PosedShape& hull, const Mat3& turn, Vec3 position, double range) const {
  double least = std::numeric_limits<double>::infinity();
  for (const HalfSpace& h : half_spaces) least = std::min(least, hull.lowest(h.normal) - h.offset);
  PosedShape placed;
  for (const Convex& c : hulls) {
    placed.place(c, turn, position);
    least = std::min(least, separate(hull, placed, range).dist);
  }
  for (const auto& tree : meshes) least = std::min(least, tree->distance(hull, range));
  return least;
}

}  // namespace hp
