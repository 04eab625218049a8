#include "collision/frame_sweep.h"

#include "geometry/gjk.h"
#include "geometry/separation.h"
#include "tuning.h"

namespace hp {

namespace tune = tuning::collision;

namespace {

struct FrameSweep {
  const CollisionWorld& world;
  BroadPhase& broad_phase;
  const Model& m;
  Poses &start, &end;
  const Sweep& sweep;
  double clear;  // the gap that counts as free [m]

  bool outside(const BroadPhasePair& e, Poses& poses, double gap);
  bool meets_static(BroadPhasePair& e);
  bool meets_shape(BroadPhasePair& e);
  bool meets_itself(BroadPhasePair& e);
  bool swept_hulls_meet(const BroadPhasePair& e, Vec3 guess, double margin);
};

// Is a shape in this pose on the outer side of all planes to a static, by more than `gap`?
bool FrameSweep::outside(const BroadPhasePair& e, Poses& poses, double gap) {
  for (const Plane& p : e.planes)
    if (p.overlaps || world.place(poses, e.shape).lowest(p.n) - p.offset <= gap) return false;
  return true;
}

bool FrameSweep::meets_static(BroadPhasePair& e) {
  const double r = sweep.travel[e.shape] + clear, bulge = sweep.bulge[e.shape];
  if (broad_phase.far(e, r)) return false;
  auto passes = [&]() {
    return broad_phase.planes_reach(e, r) && outside(e, start, clear + bulge) &&
           outside(e, end, clear + bulge);
  };
  auto passes_in_parts = [&]() {
    const double less = clear + bulge / (tune::kPathParts * tune::kPathParts);
    if (!sweep.between || !broad_phase.planes_reach(e, r) || !outside(e, start, less) ||
        !outside(e, end, less))
      return false;
    for (Poses& poses : sweep.between())
      if (!outside(e, poses, less)) return false;
    return true;
  };
  if (passes()) return false;
  broad_phase.measure_static(start, e, r + tune::kListMargin);
  return !(e.dist > r || passes() || passes_in_parts());
}

bool FrameSweep::meets_shape(BroadPhasePair& e) {
  const double r = sweep.travel[e.shape] + sweep.travel[e.other_shape] + clear;
  if (broad_phase.far(e, r)) return false;
  broad_phase.measured(e, separate(world.place(start, e.shape), world.place(start, e.other_shape),
                                   r + tune::kListMargin)
                              .dist);
  return e.dist <= r;
}

bool FrameSweep::meets_itself(BroadPhasePair& e) {
  const double bulge = sweep.bulge[e.shape] + sweep.bulge[e.other_shape] + clear,
               r = sweep.inner[e.shape] + sweep.inner[e.other_shape] + bulge;
  if (broad_phase.far(e, r) || broad_phase.spheres_apart(start, e, r)) return false;
  const PosedShape &a = world.place(start, e.shape), &b = world.place(start, e.other_shape);
  const int root = m.root[world.shapes[e.shape].body];
  // The direction that separated the two last is likely to do so still, or all the way.
  if (norm2(e.axis) > 0) {
    const Vec3 n = (1 / norm(e.axis)) * e.axis;
    const double apart = a.lowest(n) - b.highest(n);
    if (apart > r) {
      broad_phase.measured(e, apart);
      return false;
    }
    if (apart > bulge) {
      const Vec3 then = end.kin.xmat[root] * mul_t(start.kin.xmat[root], n);
      if (world.place(end, e.shape).lowest(then) - world.place(end, e.other_shape).highest(then) >
          bulge)
        return false;
    }
  }
  const Separation s = separate(a, b, r + tune::kSelfMargin, false, e.axis);
  e.axis = s.n;
  broad_phase.measured(e, s.dist);
  if (s.dist > r) return false;
  if (s.dist <= bulge) return true;
  return swept_hulls_meet(e, s.n, bulge + a.hull->radius + b.hull->radius);
}

// The hulls of both ends of two shapes, seen from the root in its axes at the start.
bool FrameSweep::swept_hulls_meet(const BroadPhasePair& e, Vec3 guess, double margin) {
  const int root = m.root[world.shapes[e.shape].body];
  const Mat3 back = start.kin.xmat[root] * transposed(end.kin.xmat[root]);
  const Vec3 shift = start.kin.xpos[root] - back * end.kin.xpos[root];
  static thread_local std::vector<double> ends[2];
  auto swept = [&](int k, int shape) {
    const Points p = world.place(start, shape).points(), q = world.place(end, shape).points();
    ends[k].resize(6 * (size_t)p.n);
    double *x = ends[k].data(), *y = x + 2 * p.n, *z = y + 2 * p.n;
    for (int i = 0; i < p.n; i++) {
      const Vec3 u = p.at(i), v = back * q.at(i) + shift;
      x[i] = u.x, y[i] = u.y, z[i] = u.z;
      x[p.n + i] = v.x, y[p.n + i] = v.y, z[p.n + i] = v.z;
    }
    return Support{{x, y, z, 2 * p.n}};
  };
  Vec3 pa, pb;
  return gjk(swept(0, e.shape), swept(1, e.other_shape), guess, pa, pb, margin) <= margin;
}

}  // namespace

void mark_busy_trees(const CollisionWorld& world, BroadPhase& broad_phase,
                     const std::vector<InitialOverlap>& overlaps, const Model& m, Poses& start,
                     Poses& end, const Sweep& sweep, std::vector<char>& busy) {
  const std::vector<CollisionShape>& shapes = world.shapes;
  for (const InitialOverlap& in : overlaps) {
    busy[m.root[shapes[in.shape].body]] = 1;
    if (in.other_shape >= 0) busy[m.root[shapes[in.other_shape].body]] = 1;
  }
  FrameSweep frame{
      world, broad_phase, m, start, end, sweep, world.settings.clearance + tune::kRounding};
  for (BroadPhasePair& e : broad_phase.pairs()) {
    const int mine = m.root[shapes[e.shape].body];
    if (e.other_shape < 0) {
      if (!busy[mine] && frame.meets_static(e)) busy[mine] = 1;
      continue;
    }
    const int its = m.root[shapes[e.other_shape].body];
    if (busy[mine] && busy[its]) continue;
    if (e.own)
      busy[mine] = frame.meets_itself(e);
    else if (frame.meets_shape(e))
      busy[mine] = busy[its] = 1;
  }
}

}  // namespace hp
