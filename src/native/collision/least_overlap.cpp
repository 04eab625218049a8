#include "collision/least_overlap.h"

#include "geometry/direction_bounds.h"
#include "geometry/separation.h"

namespace hp {

Vec3 least_overlap(const PosedShape& a, const PosedShape& b, Vec3 guess) {
  DirectionBounds bounds(a, b);
  const auto apart = [&](Vec3 n, double most) {
    if (bounds.under(n, most)) return -1e300;
    bounds.add(n);
    return a.lowest(n) - b.highest(n);
  };
  return best_direction(apart, {guess, a.center - b.center});
}

double pair_gap(const CollisionWorld& world, Poses& p, int a, int b) {
  const PosedShape &A = world.place(p, a), &B = world.place(p, b);
  const double dist = separate(A, B).dist;
  if (dist > 0) return dist;
  return separate_along(A, B, least_overlap(A, B, A.center - B.center)).dist;
}

}  // namespace hp
