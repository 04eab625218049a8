#include "collision/depenetration.h"

#include <cmath>

#include "collision/exit_search.h"
#include "collision/overlap_groups.h"
#include "geometry/separation.h"
#include "tuning.h"

namespace hp {

namespace tune = tuning::collision;

Inside* Depenetration::find(const BroadPhasePair& e) {
  for (Inside& in : inside_)
    if (in.shape == e.shape && in.other_static == e.other_static && in.other_shape == e.other_shape)
      return &in;
  return nullptr;
}

void Depenetration::clear() {
  inside_.clear();
  growth = 1;
}

Obstacle Depenetration::obstacle(Poses& start, int other_static, int other_shape) const {
  return other_static >= 0 ? Obstacle::of_static(world_, other_static)
                           : Obstacle::of_shape(world_, start, other_shape);
}

// Every tree and obstacle that overlap are looked at once, whichever of their pairs comes first.
void Depenetration::begin(const Model& m, Poses& start, const std::vector<Overlap>& overlaps) {
  auto root_of = [&](const Overlap& o) { return m.root[world_.shapes[o.shape].body]; };
  auto same = [&](const Overlap& a, const Overlap& b) {
    return a.other_static == b.other_static && a.other_shape == b.other_shape && root_of(a) == root_of(b);
  };
  for (size_t first = 0; first < overlaps.size(); first++) {
    const Overlap& pair = overlaps[first];
    bool seen = false;
    for (size_t k = 0; k < first; k++) seen |= same(overlaps[k], pair);
    if (seen) continue;
    const Obstacle o = obstacle(start, pair.other_static, pair.other_shape);
    std::vector<int> overlapping;
    for (const Overlap& other : overlaps)
      if (same(other, pair)) overlapping.push_back(other.shape);
    for (const OverlapGroup& g : overlap_groups(world_, m, start, o, root_of(pair), overlapping))
      add_group(start, o, g, ExitSearch(world_, m, start, o, g, avoid_).run());
  }
}

// A shape that is less deep than others of its group starts where it first is clear.
void Depenetration::add_group(Poses& start, const Obstacle& o, const OverlapGroup& group,
                              const Exit& exit) {
  for (int i : group.shapes) {
    if (is_inside(inside_, i, o.other_static, o.other_shape)) continue;  // on another way out already
    Inside in;
    in.shape = i, in.other_static = o.other_static, in.other_shape = o.other_shape;
    in.exit = exit.displacement;
    in.lost = norm2(in.exit) == 0;
    auto clear_at = [&](double out) {
      return o.clear(displaced(world_.place(start, i), (1 - out) * in.exit), tune::kExitClearance);
    };
    double bad = 1;
    for (double out = 0; !in.lost; out += tune::kExitStride / exit.length) {
      if (out >= 1 || !clear_at(out)) {
        bad = std::min(out, 1.0);
        break;
      }
      in.out = out;
    }
    for (int k = 0; k < tune::kExitBisections && !in.lost; k++) {
      const double out = 0.5 * (in.out + bad);
      (clear_at(out) ? in.out : bad) = out;
    }
    inside_.push_back(in);
  }
}

void Depenetration::find_planes(const PosedShape& a, const Obstacle& o, BroadPhasePair& e,
                                double range) const {
  if (o.is(Static::Kind::Mesh)) {
    o.fixed->tree->planes(a, range, e.planes);
  } else if (o.is(Static::Kind::HalfSpace)) {
    e.planes = {{o.fixed->n, o.fixed->offset, a.lowest(o.fixed->n) - o.fixed->offset, -1, false}};
  } else {
    const Separation s = separate(a, o.posed(), range, true, e.axis);
    e.axis = s.n;
    e.planes = {{s.n, o.posed().highest(s.n), s.dist, -1, false}};
  }
}

void Depenetration::add_candidates(Poses& start, BroadPhasePair& e, Inside& in, double reach, double h,
                                   std::vector<ContactCandidate>& out) {
  in.next = in.out;
  e.dist = BroadPhasePair::kUnknown;
  e.planes_reach = 0;
  const Obstacle o = obstacle(start, in.other_static, in.other_shape);
  if (in.lost) {
    if (o.clear(world_.place(start, in.shape), tune::kLeastGap)) in.next = 1;
    return;
  }
  const double speed = world_.settings.depenetration_speed, length = norm(in.exit),
               ease = std::min(1.0, std::max(tune::kLeastPace, in.depth() / tune::kEaseDepth)),
               pace = growth * ease * speed * h;
  const double r = reach + pace + tune::kExitLookAhead;
  find_planes(displaced(world_.place(start, in.shape), (1 - in.out) * in.exit), o, e, r);
  double most = (pace + tune::kExitLookAhead) / length;
  for (const Plane& p : e.planes) {
    const double closing = dot(p.n, in.exit);
    if (p.dist <= r && closing > 1e-9)
      most = std::min(most, (std::max(0.0, p.dist - tune::kLeastGap) + pace) / closing);
  }
  in.pace = ease * speed * h;
  in.next = std::min(1.0, in.out + most);
  ContactCandidate c;
  c.shape = e.shape;
  c.other_static = e.other_static;
  c.other_shape = e.other_shape;
  c.inside = (int)(&in - inside_.data());
  c.from = (1 - in.out) * in.exit;
  c.to = (1 - in.next) * in.exit;
  for (const Plane& p : e.planes)
    if (p.dist <= r && !p.overlaps) targets_.add(c, p, h, out);
}

bool Depenetration::reroute(const Model& m, Poses& start) {
  const auto stuck = std::find_if(inside_.begin(), inside_.end(),
                                  [](const Inside& in) { return in.stuck >= tune::kStuckPatience; });
  if (stuck == inside_.end()) return false;
  const Inside first = *stuck;
  std::vector<Inside> kept;
  std::vector<Overlap> overlaps;  // of its whole group
  std::vector<Inside> before = inside_;
  for (const Inside& in : inside_) {
    const bool same = in.other_static == first.other_static && in.other_shape == first.other_shape &&
                      norm2(in.exit - first.exit) == 0;
    if (same)
      overlaps.push_back({in.shape, in.other_static, in.other_shape});
    else
      kept.push_back(in);
  }
  inside_ = kept;
  avoid_ = (1 / norm(first.exit)) * first.exit;
  begin(m, start, overlaps);
  avoid_ = {};
  bool found = true;
  for (size_t k = kept.size(); k < inside_.size(); k++) found &= !inside_[k].lost;
  if (!found) inside_ = before;
  for (Inside& in : inside_) in.stuck = std::min(in.stuck, found ? in.stuck : 0);
  return true;
}

void Depenetration::advance(const std::vector<double>& share) {
  for (Inside& in : inside_) {
    const int b = world_.shapes[in.shape].body;
    if (!world_.active[b]) continue;
    const double got = in.next - in.out, slow = tune::kSlowProgress * norm(in.exit) * got;
    in.stuck = in.lost || slow >= in.pace ? 0 : in.stuck + 1;
    in.out += (share.empty() ? 1 : std::max(0.0, share[b])) * (in.next - in.out);
    in.next = in.out;
  }
  auto done = [](const Inside& in) { return in.out >= 1; };
  inside_.erase(std::remove_if(inside_.begin(), inside_.end(), done), inside_.end());
}

void Depenetration::save(std::vector<double>& out) const {
  out.push_back((double)inside_.size());
  for (const Inside& i : inside_)
    out.insert(out.end(), {(double)i.shape, (double)i.other_static, (double)i.other_shape, i.exit.x,
                           i.exit.y, i.exit.z, i.out, i.lost ? 1.0 : 0.0, (double)i.stuck});
  out.push_back(growth);
}

const double* Depenetration::load(const double* in) {
  inside_.clear();
  for (int n = (int)*in++; n > 0; n--, in += 9)
    inside_.push_back({(int)in[0], (int)in[1], (int)in[2], load3(in + 3), in[6], in[6], in[7] != 0, 0,
                       (int)in[8]});
  growth = *in++;
  return in;
}

}  // namespace hp
