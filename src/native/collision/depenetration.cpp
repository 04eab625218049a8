#include "collision/depenetration.h"

#include <algorithm>
#include <cmath>

#include "collision/exit_search.h"
#include "collision/overlap_groups.h"
#include "geometry/separation.h"
#include "tuning.h"

namespace hp {

namespace tune = tuning::collision;

InitialOverlap* Depenetration::find(const BroadPhasePair& e) {
  for (InitialOverlap& in : overlaps_)
    if (in.shape == e.shape && in.other_static == e.other_static && in.other_shape == e.other_shape)
      return &in;
  return nullptr;
}

void Depenetration::clear() {
  overlaps_.clear();
  growth = 1;
}

Obstacle Depenetration::obstacle(Poses& start, int other_static, int other_shape) const {
  return other_static >= 0 ? Obstacle::of_static(world_, other_static)
                           : Obstacle::of_shape(world_, start, other_shape);
}

// Each tree is handled once per obstacle that it overlaps, when their first pair comes.
void Depenetration::begin(const Model& m, Poses& start, const std::vector<PairId>& pairs,
                          size_t most_tests) {
  auto root_of = [&](const PairId& o) { return m.root[world_.shapes[o.shape].body]; };
  auto same = [&](const PairId& a, const PairId& b) {
    return a.other_static == b.other_static && a.other_shape == b.other_shape &&
           root_of(a) == root_of(b);
  };
  for (size_t first = 0; first < pairs.size(); first++) {
    const PairId& pair = pairs[first];
    bool seen = false;
    for (size_t k = 0; k < first; k++) seen |= same(pairs[k], pair);
    if (seen) continue;
    const Obstacle o = obstacle(start, pair.other_static, pair.other_shape);
    std::vector<int> overlapping;
    for (const PairId& other : pairs)
      if (same(other, pair)) overlapping.push_back(other.shape);
    for (const OverlapGroup& g :
         overlap_groups(world_, m, start, o, root_of(pair), overlapping, tests_))
      if (any_new(g, o))
        add_group(start, o, g,
                  ExitSearch(world_, m, start, o, g, avoid_, most_tests, tests_).run());
  }
}

// Has a shape of the group no exit from the obstacle yet?
bool Depenetration::any_new(const OverlapGroup& group, const Obstacle& o) const {
  return !std::all_of(group.shapes.begin(), group.shapes.end(), [&](int i) {
    return is_overlapping(overlaps_, i, o.other_static, o.other_shape);
  });
}

// A shape that is less deep than others of its group starts where it first is clear.
void Depenetration::add_group(Poses& start, const Obstacle& o, const OverlapGroup& group,
                              const Exit& exit) {
  for (int i : group.shapes) {
    if (is_overlapping(overlaps_, i, o.other_static, o.other_shape))
      continue;  // it has another exit already
    InitialOverlap in;
    in.shape = i, in.other_static = o.other_static, in.other_shape = o.other_shape;
    in.exit = exit.displacement;
    in.no_exit = norm2(in.exit) == 0;
    auto clear_at = [&](double out) {
      return o.clear(displaced(world_.place(start, i), (1 - out) * in.exit), tune::kExitClearance,
                     tests_);
    };
    double bad = 1;
    for (double out = 0; !in.no_exit; out += tune::kExitStride / exit.length) {
      if (out >= 1 || !clear_at(out)) {
        bad = std::min(out, 1.0);
        break;
      }
      in.progress = out;
    }
    for (int k = 0; k < tune::kExitBisections && !in.no_exit; k++) {
      const double out = 0.5 * (in.progress + bad);
      (clear_at(out) ? in.progress : bad) = out;
    }
    overlaps_.push_back(in);
  }
}

// Returns how far the planes hold, at most `range` [m].
double Depenetration::find_planes(const PosedShape& a, const Obstacle& o, BroadPhasePair& e,
                                  double range) const {
  if (o.is(Static::Kind::Mesh)) return o.fixed->tree->planes(a, range, e.planes);
  if (o.is(Static::Kind::HalfSpace)) {
    e.planes = {{o.fixed->n, o.fixed->offset, a.lowest(o.fixed->n) - o.fixed->offset, -1, false}};
  } else {
    const Separation s = separate(a, o.posed(), range, true, e.axis);
    e.axis = s.n;
    e.planes = {{s.n, o.posed().highest(s.n), s.dist, -1, false}};
  }
  return range;
}

void Depenetration::add_candidates(Poses& start, BroadPhasePair& e, InitialOverlap& in,
                                   double& reach, double h, std::vector<ContactCandidate>& out) {
  in.next_progress = in.progress;
  e.dist = BroadPhasePair::kUnknown;
  e.planes_reach = 0;
  const Obstacle o = obstacle(start, in.other_static, in.other_shape);
  if (in.no_exit) {
    if (o.clear(world_.place(start, in.shape), tune::kLeastGap, tests_))
      hold_clear(start, o, e, in, reach, h, out);
    return;
  }
  const double speed = world_.settings.depenetration_speed, length = norm(in.exit),
               ease = std::min(1.0, std::max(tune::kLeastPace, in.depth() / tune::kEaseDepth)),
               pace = growth * ease * speed * h;
  const double r = reach + pace + tune::kExitLookAhead;
  const double holds =
      find_planes(displaced(world_.place(start, in.shape), (1 - in.progress) * in.exit), o, e, r);
  double most = (pace + tune::kExitLookAhead) / length;
  if (holds < r) {  // half of it for the step, half for the way out
    reach = std::min(reach, 0.5 * holds);
    most = std::min(most, 0.5 * holds / length);
  }
  for (const Plane& p : e.planes) {
    const double closing = dot(p.n, in.exit);
    if (p.dist <= r && closing > 1e-9)
      most = std::min(most, (std::max(0.0, p.dist - tune::kLeastGap) + pace) / closing);
  }
  in.asked = ease * speed * h;
  in.next_progress = std::min(1.0, in.progress + most);
  ContactCandidate c;
  c.shape = e.shape;
  c.other_static = e.other_static;
  c.other_shape = e.other_shape;
  c.overlap = (int)(&in - overlaps_.data());
  c.from = (1 - in.progress) * in.exit;
  c.to = (1 - in.next_progress) * in.exit;
  for (const Plane& p : e.planes)
    if (p.dist <= r && !p.overlaps) targets_.add(c, p, h, out);
}

// A shape that had no way out has come clear by itself: from this substep on it is held so.
void Depenetration::hold_clear(Poses& start, const Obstacle& o, BroadPhasePair& e,
                               InitialOverlap& in, double& reach, double h,
                               std::vector<ContactCandidate>& out) {
  in.next_progress = 1;
  const double holds = find_planes(world_.place(start, in.shape), o, e, reach);
  ContactCandidate c;
  c.shape = e.shape;
  c.other_static = e.other_static;
  c.other_shape = e.other_shape;
  c.overlap = (int)(&in - overlaps_.data());
  for (const Plane& p : e.planes)
    if (p.dist <= reach) targets_.add(c, p, h, out);
  reach = std::min(reach, holds);
}

bool Depenetration::reroute(const Model& m, Poses& start) {
  const auto stuck = std::find_if(overlaps_.begin(), overlaps_.end(), [](const InitialOverlap& in) {
    return in.stuck >= tune::kStuckPatience;
  });
  if (stuck == overlaps_.end()) return false;
  const InitialOverlap first = *stuck;
  std::vector<InitialOverlap> kept;
  std::vector<PairId> again;  // its whole group
  std::vector<InitialOverlap> before = overlaps_;
  for (const InitialOverlap& in : overlaps_) {
    const bool same = in.other_static == first.other_static &&
                      in.other_shape == first.other_shape && norm2(in.exit - first.exit) == 0;
    if (same)
      again.push_back({in.shape, in.other_static, in.other_shape});
    else
      kept.push_back(in);
  }
  overlaps_ = kept;
  avoid_ = (1 / norm(first.exit)) * first.exit;
  begin(m, start, again, tune::kMostExitTests);
  avoid_ = {};
  // What was clear stays so, cut off by now or not: no other part of the person gets a way out.
  const auto other = [&](const InitialOverlap& in) {
    return std::none_of(again.begin(), again.end(),
                        [&](const PairId& pair) { return pair.shape == in.shape; });
  };
  overlaps_.erase(std::remove_if(overlaps_.begin() + (long)kept.size(), overlaps_.end(), other),
                  overlaps_.end());
  bool found = true;
  for (size_t k = kept.size(); k < overlaps_.size(); k++) found &= !overlaps_[k].no_exit;
  if (!found) overlaps_ = before;
  for (InitialOverlap& in : overlaps_) in.stuck = std::min(in.stuck, found ? in.stuck : 0);
  return true;
}

void Depenetration::advance(const std::vector<double>& share) {
  for (InitialOverlap& in : overlaps_) {
    const int b = world_.shapes[in.shape].body;
    if (!world_.active[b]) continue;
    const double gained = in.next_progress - in.progress;
    const bool progressed = tune::kSlowProgress * norm(in.exit) * gained >= in.asked;
    in.stuck = in.no_exit || progressed ? 0 : in.stuck + 1;
    in.progress += (share.empty() ? 1 : std::max(0.0, share[b])) * (in.next_progress - in.progress);
    in.next_progress = in.progress;
  }
  auto done = [](const InitialOverlap& in) { return in.progress >= 1; };
  overlaps_.erase(std::remove_if(overlaps_.begin(), overlaps_.end(), done), overlaps_.end());
}

void Depenetration::save(std::vector<double>& out) const {
  out.push_back((double)overlaps_.size());
  for (const InitialOverlap& i : overlaps_)
    out.insert(out.end(), {(double)i.shape, (double)i.other_static, (double)i.other_shape, i.exit.x,
                           i.exit.y, i.exit.z, i.progress, i.no_exit ? 1.0 : 0.0, (double)i.stuck});
  out.push_back(growth);
}

const double* Depenetration::load(const double* in) {
  overlaps_.clear();
  for (int n = (int)*in++; n > 0; n--, in += 9)
    overlaps_.push_back({(int)in[0], (int)in[1], (int)in[2], load3(in + 3), in[6], in[6],
                         in[7] != 0, 0, (int)in[8]});
  growth = *in++;
  return in;
}

}  // namespace hp
