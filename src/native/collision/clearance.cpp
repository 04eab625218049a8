// How near the people's shapes are to what stands: measured, for reports; nothing is decided by it.
#include <limits>

#include "collision/narrow_phase.h"

namespace hp {

namespace {

constexpr double kFar = std::numeric_limits<double>::infinity();
// A mesh is asked for distances up to this at least: 0 would ask for nothing [m].
constexpr double kLeastRange = 1e-9;

}  // namespace

double World::clearance(const Model& m, Poses& p, double range) const {
  double best = range;
  auto measure = [&](int i, const Static& S, const std::vector<Plane>& near) {
    const Poses::Ball ball = p.ball(shapes[i]);
    if (S.kind == Static::Kind::HalfSpace) {
      if (dot(S.n, ball.center) - ball.radius - S.offset < best)
        best = std::min(best, place(p, i).lowest(S.n) - S.offset);
      return;
    }
    Box3 box;
    box.add(ball.center);
    box.grow(ball.radius + std::max(best, 0.0));
    if (S.kind == Static::Kind::Hull) {
      if (box.meets(S.placed.box))
        best = std::min(best, separate(place(p, i), S.placed, std::max(best, 0.0)).dist);
    } else if (box.meets(S.tree->box())) {
      best = std::min(best, S.tree->distance(place(p, i), std::max(best, kLeastRange), near));
    }
  };
  bool listed = has_list_;
  for (size_t i = 0; i < shapes.size() && listed; i++)
    listed = shapes[i].person < 0 || odometer_[i] - listed_[i] + range <= range_[i];
  if (listed) {
    for (const BroadPhasePair& e : broad_pairs_) {
      if (shapes[e.shape].person < 0 || e.other_static < 0 || far(e, best)) continue;
      if (best >= 0 && behind_planes(e, place(p, e.shape), best)) continue;
      measure(e.shape, statics[e.other_static], e.planes);
    }
  } else {
    for (int i = 0; i < (int)shapes.size(); i++)
      if (shapes[i].person >= 0)
        for (const Static& S : statics)
          if (!pairing(shapes[i].name, S.name).ignore) measure(i, S, {});
  }
  (void)m;
  return best < range ? best : kFar;
}

void World::clearances(Poses& p, double range, double* dist, int* nearest) const {
  for (int i = 0; i < (int)shapes.size(); i++) {
    const CollisionShape& M = shapes[i];
    dist[i] = std::numeric_limits<double>::quiet_NaN();
    nearest[i] = -1;
    if (M.person < 0) continue;
    const Poses::Ball ball = p.ball(M);
    double best = range;
    for (int j = 0; j < (int)statics.size(); j++) {
      const Static& S = statics[j];
      if (pairing(M.name, S.name).ignore) continue;
      double d = kFar;
      Box3 box;
      box.add(ball.center);
      box.grow(ball.radius + std::max(best, 0.0));
      if (S.kind == Static::Kind::HalfSpace) {
        if (dot(S.n, ball.center) - ball.radius - S.offset < best)
          d = place(p, i).lowest(S.n) - S.offset;
      } else if (S.kind == Static::Kind::Hull) {
        if (box.meets(S.placed.box))
          d = separate(place(p, i), S.placed, std::max(best, 0.0)).dist;
      } else if (box.meets(S.tree->box())) {
        d = S.tree->distance(place(p, i), std::max(best, kLeastRange));
      }
      if (d < best) best = d, nearest[i] = j;
    }
    dist[i] = nearest[i] >= 0 ? best : kFar;
  }
}

}  // namespace hp
