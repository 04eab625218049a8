#include "collision/narrow_phase.h"

#include "collision/least_overlap.h"
#include "geometry/separation.h"
#include "tuning.h"

namespace hp {

namespace tune = tuning::collision;

void NarrowPhase::gather(const Model& m, Poses& start, std::vector<double>& valid, double h,
                         std::vector<ContactCandidate>& out) {
  out.clear();
  forced_.update(m, start, broad_phase_.pairs());
  parting_.update(start);
  if (world_.forced) last_.forget();
  last_.begin(start.stamp, h, valid);
  for (const InitialOverlap& in : depenetration_.overlaps()) last_.renew(in.shape);
  for (BroadPhasePair& e : broad_phase_.pairs())
    if (world_.takes_part(e) && !last_.repeat(e, out)) measure(m, start, e, valid, h, out);
  last_.end(valid, out);
}

void NarrowPhase::measure(const Model& m, Poses& start, BroadPhasePair& e,
                          std::vector<double>& valid, double h,
                          std::vector<ContactCandidate>& out) {
  const double r = valid[e.shape] + (e.other_shape >= 0 ? valid[e.other_shape] : 0.0);
  if (depenetration_.any())
    if (InitialOverlap* in = depenetration_.find(e)) {
      double holds = r;
      depenetration_.add_candidates(start, e, *in, holds, h, out);
      if (holds < r) valid[e.shape] = std::min(valid[e.shape], holds);
      return;
    }
  if (broad_phase_.far(e, r)) return;
  ContactCandidate c;
  c.shape = e.shape;
  c.other_static = e.other_static;
  c.other_shape = e.other_shape;
  if (add_bound(e, c, Known::Travel, broad_phase_.bound(e), r, h, out)) return;
  if (e.other_shape >= 0) return add_shapes(m, start, e, c, r, h, out);
  const PosedShape& a = world_.place(start, e.shape);
  if (world_.statics[e.other_static].kind == Static::Kind::HalfSpace)
    add_half_space(a, e, c, r, h, out);
  else
    add_static(m, start, a, e, c, valid[e.shape], h, out);
}

// The candidate of a pair whose plane need not be known yet; false if it is to be sought. `bound`: of the
// pair's distance.
bool NarrowPhase::add_bound(BroadPhasePair& e, ContactCandidate& c, Known by, double bound,
                            double r, double h, std::vector<ContactCandidate>& out) {
  if (world_.forced || bound < world_.settings.clearance + tune::kWaitingGap) return false;
  // A person who moves goes farther than their parts are apart. Piles of objects keep their planes.
  if (e.own || world_.shapes[e.shape].person < 0) return false;
  if (e.other_static >= 0 && world_.statics[e.other_static].kind == Static::Kind::Mesh)
    return false;
  if (e.other_shape >= 0 && parting_.any() && parting_.between(e.shape, e.other_shape))
    return false;
  if (by == Known::Direction) broad_phase_.measured(e, bound);
  if (bound > r) return true;
  c.known = by;
  c.dist = bound;
  targets_.set(c, h);
  out.push_back(c);
  return true;
}

// By how much the direction of the last measurement separates the two; none, if there is none.
double NarrowPhase::bound_along(Poses& start, const BroadPhasePair& e) const {
  if (norm2(e.axis) == 0) return BroadPhasePair::kUnknown;
  const double low = world_.place(start, e.shape).lowest(e.axis);
  return low - (e.other_shape >= 0 ? world_.place(start, e.other_shape).highest(e.axis)
                                   : world_.statics[e.other_static].posed.highest(e.axis));
}

void NarrowPhase::refine(const Model& m, Poses& start, double h, int index,
                         std::vector<ContactCandidate>& all) {
  ContactCandidate& c = all[index];
  BroadPhasePair& e = broad_phase_.pair_of(c);
  const bool travel = c.known == Known::Travel;
  const double bound = travel ? bound_along(start, e) : BroadPhasePair::kUnknown;
  if (bound > c.dist) {
    c.known = Known::Direction;
    c.dist = bound;
    broad_phase_.measured(e, bound);
    return last_.replace(index, c);
  }
  ContactCandidate k;
  k.shape = c.shape, k.other_static = c.other_static, k.other_shape = c.other_shape;
  refined_.clear();
  if (c.other_shape >= 0) {
    measure_shapes(m, start, e, k, BroadPhasePair::kEverywhere, h, refined_);
  } else if (world_.statics[c.other_static].kind == Static::Kind::HalfSpace) {
    add_half_space(world_.place(start, c.shape), e, k, BroadPhasePair::kEverywhere, h, refined_);
  } else {
    broad_phase_.measure_static(start, e, BroadPhasePair::kEverywhere);
    add_hull(world_.place(start, c.shape), e, k, h, refined_);
  }
  k = refined_[0];
  k.island = c.island;
  k.share = c.share;
  k.target = std::min(k.target, c.target);  // it may have given way
  c = k;
  last_.replace(index, c);
}

void NarrowPhase::add_half_space(const PosedShape& a, BroadPhasePair& e, ContactCandidate& c,
                                 double r, double h, std::vector<ContactCandidate>& out) {
  const Static& S = world_.statics[e.other_static];
  c.n = S.n;
  c.offset = S.offset;
  c.dist = a.lowest(S.n) - S.offset;
  broad_phase_.measured(e, c.dist);
  if (c.dist > r) return;
  targets_.set(c, h);
  out.push_back(c);
}

// The exit direction of a pair that overlaps: fixed in `frame` when the overlap is first found,
// dropped when it ends.
void NarrowPhase::fix_exit(const PosedShape& a, const PosedShape& b, const Mat3& frame,
                           ContactCandidate& c) {
  PairState* state = states_.find(c);
  const bool known = state && state->overlapping;
  if (c.dist >= 0) {
    if (known) state->overlapping = false;
  } else if (known) {
    c.n = frame * state->exit;
    c.dist = separate_along(a, b, c.n).dist;
  } else {
    if (!state) state = &states_.add(c, {world_.settings.clearance, false, {}});
    state->overlapping = true;
    state->exit = mul_t(frame, c.n);
  }
}

// In a pair of a person and an object the person comes first: the normal points into the part.
void NarrowPhase::add_shapes(const Model& m, Poses& start, BroadPhasePair& e, ContactCandidate& c,
                             double r, double h, std::vector<ContactCandidate>& out) {
  if (parting_.any() && parting_.between(e.shape, e.other_shape)) return;
  if (e.own && broad_phase_.spheres_apart(start, e, r)) return;
  // A pair that was far would have left the list if others had had it made anew: it begins afresh.
  if (e.dist > r) e.axis = {}, e.hint = {};
  if (!add_bound(e, c, Known::Direction, bound_along(start, e), r, h, out))
    measure_shapes(m, start, e, c, r, h, out);
}

void NarrowPhase::measure_shapes(const Model& m, Poses& start, BroadPhasePair& e,
                                 ContactCandidate& c, double r, double h,
                                 std::vector<ContactCandidate>& out) {
  const PosedShape &a = world_.place(start, e.shape), &b = world_.place(start, e.other_shape);
  const Separation s = separate(a, b, e.dist > r ? r + tune::kLookAhead : r, true, e.axis, &e.hint);
  e.axis = s.n;
  broad_phase_.measured(e, s.dist);
  if (s.dist > r) return;
  c.n = s.n;
  c.dist = s.dist;
  c.hint = e.hint;
  c.pa = s.pa, c.pb = s.pb;
  if (e.own && c.dist < 0) {
    const PairState* state = states_.find(c);
    if (!state || !state->overlapping) {
      c.n = least_overlap(a, b, c.n);
      c.dist = separate_along(a, b, c.n).dist;
    }
  }
  fix_exit(a, b, e.own ? start.kin.xmat[self_.reference_body(m, c)] : Mat3{}, c);
  targets_.set(c, h);
  out.push_back(c);
}

// An overlap that no step can have made.
void NarrowPhase::resolve(const Model& m, Poses& start, BroadPhasePair& e, double& valid, double h,
                          std::vector<ContactCandidate>& out) {
  if (world_.forced && world_.shapes[e.shape].person >= 0) return;  // static geometry stops no pose
  depenetration_.begin(m, start, {{e.shape, e.other_static, e.other_shape}}, tune::kMostExitTests);
  broad_phase_.invalidate();  // shapes that are cut off are to be listed too
  if (InitialOverlap* in = depenetration_.find(e))
    depenetration_.add_candidates(start, e, *in, valid, h, out);
}

// Of a static hull that has been measured.
void NarrowPhase::add_hull(const PosedShape& a, const BroadPhasePair& e, ContactCandidate& c,
                           double h, std::vector<ContactCandidate>& out) {
  const Static& S = world_.statics[e.other_static];
  c.n = e.planes[0].n;
  c.dist = e.dist;
  fix_exit(a, S.posed, Mat3{}, c);
  c.offset = S.posed.highest(c.n);
  targets_.set(c, h);
  out.push_back(c);
}

void NarrowPhase::add_static(const Model& m, Poses& start, const PosedShape& a, BroadPhasePair& e,
                             ContactCandidate& c, double& valid, double h,
                             std::vector<ContactCandidate>& out) {
  const double r = valid;
  if (broad_phase_.behind_planes(e, a, r)) return;
  if (e.dist > r) e.axis = {}, e.hint = {};
  const Static& S = world_.statics[e.other_static];
  // (All of a hull lies behind each of its planes, however far the shape has travelled.)
  if (S.kind == Static::Kind::Hull &&
      add_bound(e, c, Known::Direction, bound_along(start, e), r, h, out))
    return;
  // A pair that was near will be measured again in the next substep anyhow; one that was not is
  // measured a little farther, so that its bound lasts.
  broad_phase_.measure_static(
      start, e, e.dist > r || e.dist == BroadPhasePair::kUnknown ? r + tune::kLookAhead : r,
      &tests_);
  if (S.kind == Static::Kind::Hull) {
    if (e.dist <= r) add_hull(a, e, c, h, out);
    return;
  }
  bool overlaps = false;
  for (const Plane& p : e.planes) overlaps |= p.overlaps;
  if (overlaps) return resolve(m, start, e, valid, h, out);
  valid = std::min(valid, e.planes_reach);
  for (const Plane& p : e.planes)
    if (p.dist <= valid) targets_.add(c, p, h, out);
}

void NarrowPhase::search_behind(Poses& start, std::vector<double>& valid, double h, int index,
                                std::vector<ContactCandidate>& all) {
  ContactCandidate c = all[index];
  std::vector<int> without, known;
  std::vector<Plane> planes;
  for (const ContactCandidate& k : all) {
    if (k.shape != c.shape || k.other_static != c.other_static) continue;
    known.push_back(k.triangle);
    if (k.searched)
      without.push_back(k.triangle);
    else
      planes.push_back({k.n, k.offset, k.dist, k.triangle, false});
  }
  std::sort(without.begin(), without.end());
  std::sort(known.begin(), known.end());
  double& reach = valid[c.shape];
  const PosedShape& a = world_.place(start, c.shape);
  reach = world_.statics[c.other_static].tree->planes(displaced(a, c.from), reach, planes, without,
                                                      &tests_);
  c.searched = c.forgiven = false;
  for (const Plane& p : planes)
    if (!std::binary_search(known.begin(), known.end(), p.triangle)) targets_.add(c, p, h, all);
}

}  // namespace hp
