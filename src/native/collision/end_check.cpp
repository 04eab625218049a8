#include "collision/end_check.h"

#include "collision/least_overlap.h"
#include "collision/relative_travel.h"
#include "geometry/separation.h"
#include "tuning.h"

namespace hp {

namespace tune = tuning::collision;

namespace {

double spheres_gap(const BoundingSphere& a, const BoundingSphere& b) {
  return norm(a.center - b.center) - a.radius - b.radius;
}

// By how much a direction separates two shapes; the one that GJK finds if the last one does not. What an
// overlap costs more is added to `tests` (geometry/bvh.h).
double shape_gap(const PosedShape& a, const PosedShape& b, SeparatingAxes& axes, size_t& tests) {
  const Vec3 last = axes.n[0];
  if (norm2(last) > 0) {
    const double apart = a.lowest(last) - b.highest(last);
    if (apart > 0) return apart;
  }
  const Separation s = separate(a, b, tune::kEndLook, true, last);
  const double length = norm(s.n);
  if (length == 0) return s.dist;
  if (s.dist <= 0)
    tests += tune::kDirectionTests *
             (a.hull->normals.size() + b.hull->normals.size() + tune::kLatticeDirections);
  axes.n[0] = s.dist > 0 ? (1 / length) * s.n : least_overlap(a, b, s.n);
  return a.lowest(axes.n[0]) - b.highest(axes.n[0]);
}

}  // namespace

// A lower bound of the distance where it is positive, else minus the depth.
double EndCheck::gap(Poses& p, const BroadPhasePair& e, SeparatingAxes& axes, bool least) {
  if (e.own) {  // most of a person's pairs need no vertex posed
    const double apart = spheres_gap(p.cached_bounding_sphere(world_.shapes, e.shape),
                                     p.cached_bounding_sphere(world_.shapes, e.other_shape));
    if (apart > 0) return apart;
  }
  const PosedShape& a = world_.place(p, e.shape);
  if (e.other_shape >= 0) return shape_gap(a, world_.place(p, e.other_shape), axes, tests_);
  const Static& S = world_.statics[e.other_static];
  if (S.kind == Static::Kind::HalfSpace) return a.lowest(S.n) - S.offset;
  if (S.kind == Static::Kind::Hull) return shape_gap(a, S.posed, axes, tests_);
  return S.tree->gap(a, tune::kEndLook, axes, tests_, least);
}

// By how much the direction that was found last separates a pair at the start, of those that were measured
// there, whose vertices are posed; 0 of others.
double EndCheck::room_at(Poses& start, const BroadPhasePair& e) const {
  if (e.travelled != broad_phase_.travelled(e)) return 0;
  const PosedShape& a = world_.place(start, e.shape);
  const Vec3 n = norm2(e.axis) > 0 ? e.axis : e.axes.n[0];
  if (e.other_shape >= 0) {
    if (norm2(n) == 0) return 0;
    return a.lowest(n) - world_.place(start, e.other_shape).highest(n);
  }
  const Static& S = world_.statics[e.other_static];
  if (S.kind == Static::Kind::HalfSpace) return a.lowest(S.n) - S.offset;
  return S.kind == Static::Kind::Hull && norm2(n) > 0 ? a.lowest(n) - S.posed.highest(n) : 0;
}

// Overlaps that are resolved, and prescribed poses, which nothing stops.
bool EndCheck::exempt(const BroadPhasePair& e) const {
  const std::vector<CollisionShape>& shapes = world_.shapes;
  if (world_.forced &&
      (shapes[e.shape].person >= 0 || (e.other_shape >= 0 && shapes[e.other_shape].person >= 0)))
    return true;
  const PairState* state = states_.find(e);
  if (state && (state->kept || (state->overlapping && e.own))) return true;
  if (e.other_shape >= 0 && parting_.any() && parting_.between(e.shape, e.other_shape)) return true;
  const InitialOverlap* in = depenetration_.any() ? depenetration_.find(e) : nullptr;
  return in && !in->held_clear();
}

bool EndCheck::breached(Poses& start, Poses& end, const BroadPhasePair& e, double gap) {
  if (gap >= -tune::kBreach) return false;
  SeparatingAxes axes = e.axes;
  const double before = this->gap(start, e, axes, true);
  if (before >= -tune::kBreach) return true;
  // Overlaps at the start of the simulation come out along a direction that is not the shortest.
  const PairState* state = states_.find(e);
  if (state && state->overlapping && before < -tune::kRestingOverlap) return false;
  return this->gap(end, e, axes, true) < before - tune::kDeeper;
}

const std::vector<size_t>& EndCheck::find(Poses& start, Poses& end, const std::vector<double>& way,
                                          const std::vector<double>& inner) {
  if (stamp_ == end.stamp) return breached_;
  stamp_ = end.stamp;
  breached_.clear();
  measured_.clear();
  std::vector<BroadPhasePair>& pairs = broad_phase_.pairs();
  for (size_t i = 0; i < pairs.size(); i++) {
    BroadPhasePair& e = pairs[i];
    const std::vector<double>& moved = e.own ? inner : way;
    double went = moved[e.shape] + (e.other_shape >= 0 ? moved[e.other_shape] : 0.0);
    const double known = e.room - (broad_phase_.travelled(e) - e.room_at);
    if (known > went) continue;
    if (!world_.takes_part(e) || exempt(e)) continue;
    if (!e.own) went = pair_travel(world_, e, start, end, way);
    // What stays where it is breaches nothing; of a touch that the normal says is deep gap() does.
    if (known > went || went == 0) continue;
    // Most of a person's pairs are apart by their spheres, for which nothing is posed: gap() tries them first.
    const double left = e.own ? 0.0 : room_at(start, e) - went;
    const double now = left > 0 ? left : gap(end, e, e.axes);
    measured_.push_back({i, std::max(0.0, now)});
    if (breached(start, end, e, now)) breached_.push_back(i);
  }
  tests_ += tune::kLookTests * measured_.size();
  return breached_;
}

bool EndCheck::breached_at(Poses& start, Poses& end, size_t pair) {
  BroadPhasePair& e = broad_phase_.pairs()[pair];
  tests_ += tune::kLookTests;
  return breached(start, end, e, gap(end, e, e.axes));
}

std::vector<Breach> EndCheck::commit(Poses& end) {
  std::vector<BroadPhasePair>& pairs = broad_phase_.pairs();
  for (const Measured& k : measured_) {
    pairs[k.pair].room = k.room;
    pairs[k.pair].room_at = broad_phase_.travelled(pairs[k.pair]);
  }
  measured_.clear();
  std::vector<Breach> out;
  for (size_t i : breached_) {
    BroadPhasePair& e = pairs[i];
    const double depth = -gap(end, e, e.axes, true);
    // A step that is shortened until nothing is deeper ends right there, but for the noise.
    if (depth > tune::kBreach + tune::kDeeper)
      out.push_back({{e.shape, e.other_static, e.other_shape}, depth});
  }
  return out;
}

}  // namespace hp
