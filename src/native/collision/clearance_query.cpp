#include "collision/clearance_query.h"

#include <limits>

#include "geometry/separation.h"
#include "tuning.h"

namespace hp {

namespace tune = tuning::collision;

namespace {

constexpr double kFar = std::numeric_limits<double>::infinity();

// Distance of shape i from a static if it is less than `best`, else any larger number.
double distance_below(const CollisionWorld& world, Poses& p, int i, const BoundingSphere& sphere,
                      const Static& S, double best, const std::vector<Plane>& near) {
  if (S.kind == Static::Kind::HalfSpace) {
    if (dot(S.n, sphere.center) - sphere.radius - S.offset >= best) return kFar;
    return world.place(p, i).lowest(S.n) - S.offset;
  }
  Box3 box;
  box.add(sphere.center);
  box.grow(sphere.radius + std::max(best, 0.0));
  if (S.kind == Static::Kind::Hull)
    return box.meets(S.posed.box()) ? separate(world.place(p, i), S.posed, std::max(best, 0.0)).dist
                                    : kFar;
  return box.meets(S.tree->box())
             ? S.tree->distance(world.place(p, i), std::max(best, tune::kLeastRange), near)
             : kFar;
}

}  // namespace

double smallest_clearance(const CollisionWorld& world, const BroadPhase& broad_phase, Poses& p,
                          double range) {
  const std::vector<CollisionShape>& shapes = world.shapes;
  double best = range;
  auto measure = [&](int i, const Static& S, const std::vector<Plane>& near) {
    const BoundingSphere sphere = p.bounding_sphere(shapes[i]);
    best = std::min(best, distance_below(world, p, i, sphere, S, best, near));
  };
  if (broad_phase.covers_people(range)) {
    for (const BroadPhasePair& e : broad_phase.pairs()) {
      if (shapes[e.shape].person < 0 || e.other_static < 0 || broad_phase.far(e, best)) continue;
      if (best >= 0 && broad_phase.behind_planes(e, world.place(p, e.shape), best)) continue;
      measure(e.shape, world.statics[e.other_static], e.planes);
    }
  } else {
    for (int i = 0; i < (int)shapes.size(); i++)
      if (shapes[i].person >= 0)
        for (const Static& S : world.statics)
          if (!world.pairing(shapes[i].name, S.name).ignore) measure(i, S, {});
  }
  return best < range ? best : kFar;
}

void shape_clearances(const CollisionWorld& world, Poses& p, double range, double* dist,
                      int* nearest) {
  for (int i = 0; i < (int)world.shapes.size(); i++) {
    const CollisionShape& M = world.shapes[i];
    dist[i] = std::numeric_limits<double>::quiet_NaN();
    nearest[i] = -1;
    if (M.person < 0) continue;
    const BoundingSphere sphere = p.bounding_sphere(M);
    double best = range;
    for (int j = 0; j < (int)world.statics.size(); j++) {
      const Static& S = world.statics[j];
      if (world.pairing(M.name, S.name).ignore) continue;
      const double d = distance_below(world, p, i, sphere, S, best, {});
      if (d < best) best = d, nearest[i] = j;
    }
    dist[i] = nearest[i] >= 0 ? best : kFar;
  }
}

}  // namespace hp
