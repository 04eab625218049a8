// The direction along which two convex shapes overlap least, searched over the sphere.
//
// separate() (geometry/convex.h) knows only face normals and the line between centres: enough for
// hulls with few, large faces, a poor bound for hulls of a skin with hundreds of small ones. Here
// the guesses and the points of a Fibonacci lattice are tried, and the best is refined by a pattern
// search: turned in eight directions, by half as much whenever none is better. The result is an
// upper bound of the penetration depth; nothing guarantees the global minimum.
#pragma once
#include <vector>

#include "collision/collision_world.h"
#include "geometry/convex.h"
#include "tuning.h"

namespace hp {

// The unit direction n in which apart(n, most) is largest; where that is less than `most` it may be
// anything less.
template <typename Apart>
Vec3 best_direction(Apart apart, const std::vector<Vec3>& guesses) {
  namespace tune = tuning::collision;
  Vec3 best;
  double most = -1e300;
  auto attempt = [&](Vec3 n) {
    const double length = norm(n);
    if (length < 1e-12) return false;
    n = (1 / length) * n;
    const double dist = apart(n, most);
    if (dist <= most) return false;
    most = dist, best = n;
    return true;
  };
  for (Vec3 n : guesses) attempt(n);
  const double golden = M_PI * (3 - std::sqrt(5.0));
  for (int k = 0; k < tune::kLatticeDirections; k++) {
    const double z = 1 - (2 * k + 1.0) / tune::kLatticeDirections, r = std::sqrt(1 - z * z);
    attempt({r * elementary::cos(golden * k), r * elementary::sin(golden * k), z});
  }
  double turn = tune::kFirstTurn;
  for (int k = 0; k < tune::kRefinements && turn > tune::kLastTurn; k++) {
    Vec3 t, s;
    tangents(best, t, s);
    const Vec3 from = best;
    bool better = false;
    for (Vec3 d : {t, s, -t, -s, t + s, t - s, s - t, -t - s}) better |= attempt(from + turn * d);
    if (!better) turn *= 0.5;
  }
  return best;
}

// From b to a.
Vec3 least_overlap(const PosedShape& a, const PosedShape& b, Vec3 guess);

// Distance of two shapes; where they overlap, minus the least depth found [m].
double pair_gap(const CollisionWorld& world, Poses& p, int a, int b);

}  // namespace hp
