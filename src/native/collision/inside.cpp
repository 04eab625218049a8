// Who starts inside something that stands, and how it comes out.
//
// A hull that overlaps a static is held clear of it where it would be after a displacement: the
// smallest one that takes it, and all hulls near it in the skeleton that are inside too, out on the
// right side. The displacement only shrinks, no faster than the hull can follow it, until the hull
// itself is clear. A step of nothing at all is always possible, so nobody gets deeper.
#include <cmath>
#include <numeric>

#include "collision/narrow_phase.h"

namespace hp {

namespace {

constexpr double kTouch = 1e-5;    // overlaps up to this at the start are contacts at rest [m]
constexpr double kClear = 2e-4;    // displaced hulls start this far outside [m]
constexpr double kStride = 5e-3;   // between the displacements that are tried [m]
constexpr double kFarthest = 0.6;  // of them [m]
constexpr double kLook = 0.02;     // faces this near show ways out [m]
constexpr double kAhead = 5e-3;    // planes are asked for this much farther than is needed [m]
constexpr double kEase = 0.01, kLeastPace = 0.1;  // from this depth on slower, but not than this share [m]
constexpr int kBisections = 7, kMostWays = 80;
constexpr double kGreatPart = 0.1;  // of the mass of a body: less is never the right side
constexpr double kSameWay = 0.999, kOtherWay = 0.7;
// Who gets on less than a share of what is asked for so many substeps tries another way.
constexpr double kSlow = 10;
constexpr int kPatience = 24;

// A straight bone, as a shape.
struct Bone {
  Convex shape;
  PosedShape placed;
  Bone(Vec3 a, Vec3 b) {
    shape.vertices = {a, b};
    shape.finish();
    placed.place(shape, {}, {});
  }
};

void add_way(std::vector<Vec3>& ways, Vec3 n) {
  const double length = norm(n);
  if (length < 1e-9 || (int)ways.size() >= kMostWays) return;
  n = (1 / length) * n;
  for (Vec3 w : ways)
    if (dot(w, n) > kSameWay) return;
  ways.push_back(n);
}

}  // namespace

// What somebody is inside: something that stands, or a thing, where it is at the start.
struct World::Obstacle {
  int other_static = -1, other_shape = -1, name = 0;
  const Static* fixed = nullptr;
  const PosedShape* thing = nullptr;

  const PosedShape& hull() const { return thing ? *thing : fixed->placed; }
  bool is(Static::Kind kind) const { return fixed && fixed->kind == kind; }
  bool meets(const Box3& box) const {
    if (is(Static::Kind::Mesh)) return box.meets(fixed->tree->box());
    return is(Static::Kind::HalfSpace) || box.meets(hull().box);
  }
  bool clear(const PosedShape& a, double range) const {
    if (is(Static::Kind::HalfSpace)) return a.lowest(fixed->n) - fixed->offset >= range;
    if (is(Static::Kind::Mesh)) return fixed->tree->distance(a, 2 * range) >= range;
    return separate(a, hull(), 2 * range, false).dist >= range;
  }
  bool crosses(Vec3 a, Vec3 b) const {
    if (is(Static::Kind::HalfSpace)) return std::min(dot(fixed->n, a), dot(fixed->n, b)) <= fixed->offset;
    return !clear(Bone(a, b).placed, kTouch);
  }
};

Inside* World::inside_of(const BroadPhasePair& e) {
  for (Inside& in : inside_)
    if (in.shape == e.shape && in.other_static == e.other_static && in.other_shape == e.other_shape)
      return &in;
  return nullptr;
}

bool World::is_inside(int shape, int other_static, int other_shape) const {
  for (const Inside& in : inside_)
    if (in.shape == shape && in.other_static == other_static && in.other_shape == other_shape)
      return true;
  return false;
}

bool World::clear_of(Poses& start, int shape, const Obstacle& o, Vec3 shift, double range) const {
  return o.clear(displaced(place(start, shape), shift), range);
}

// All hulls of one tree that overlap one obstacle, and those that it cuts off from the rest of the body.
void World::find_inside(const Model& m, Poses& start, const std::vector<Overlap>& overlaps) {
  auto root_of = [&](const Overlap& o) { return m.root[shapes[o.shape].body]; };
  auto same = [&](const Overlap& a, const Overlap& b) {
    return a.other_static == b.other_static && a.other_shape == b.other_shape && root_of(a) == root_of(b);
  };
  for (size_t first = 0; first < overlaps.size(); first++) {
    const Overlap& pair = overlaps[first];
    const int root = root_of(pair);
    bool seen = false;
    for (size_t k = 0; k < first; k++) seen |= same(overlaps[k], pair);
    if (seen) continue;
    Obstacle o;
    o.other_static = pair.other_static, o.other_shape = pair.other_shape;
    if (o.other_static >= 0)
      o.fixed = &statics[o.other_static], o.name = o.fixed->name;
    else
      o.thing = &place(start, o.other_shape), o.name = shapes[o.other_shape].name;
    // The bones that it cuts, and what hangs together without them.
    std::vector<int> whole(m.nbody), group(m.nbody);
    std::iota(whole.begin(), whole.end(), 0);
    std::iota(group.begin(), group.end(), 0);
    auto find = [&](std::vector<int>& set, int b) {
      while (set[b] != b) b = set[b] = set[set[b]];
      return b;
    };
    std::vector<double> mass(m.nbody, 0);
    for (int b = 1; b < m.nbody; b++) {
      if (m.root[b] != root || b == root) continue;
      const int p = m.parent[b];
      if (!o.crosses(start.kin.xpos[p], start.kin.xpos[b])) whole[find(whole, b)] = find(whole, p);
    }
    // The greater part is the right side; but not what a closed mesh swallows whole.
    int main = find(whole, root);
    double all = 0, least = 1e300;
    for (int b = 1; b < m.nbody; b++)
      if (m.root[b] == root) mass[find(whole, b)] += m.mass[b], all += m.mass[b];
    for (int b = 1; b < m.nbody; b++) {
      if (m.root[b] != root || mass[b] <= kGreatPart * all) continue;
      const double within =
          o.is(Static::Kind::Mesh) ? std::round(o.fixed->tree->winding(start.kin.xpos[b])) : 0;
      if (within < least || (within == least && mass[b] > mass[main])) least = within, main = b;
    }
    std::vector<char> in(shapes.size(), 0), body_in(m.nbody, 0);
    for (const Overlap& other : overlaps)
      if (same(other, pair)) in[other.shape] = 1;
    for (size_t i = 0; i < shapes.size(); i++) {
      const int b = shapes[i].body;
      if (m.root[b] != root || pairing(shapes[i].name, o.name).ignore) continue;
      // A thing is gone round: what it cuts off is on no wrong side.
      if (o.fixed && find(whole, b) != main) in[i] = 1;
      if (in[i]) body_in[b] = 1;
    }
    // Those that are neighbours in the skeleton go out together.
    for (int b = 1; b < m.nbody; b++)
      if (body_in[b] && b != root && body_in[m.parent[b]])
        group[find(group, b)] = find(group, m.parent[b]);
    for (int g = 1; g < m.nbody; g++) {
      if (!body_in[g] || find(group, g) != g) continue;
      std::vector<int> mine;
      for (size_t i = 0; i < shapes.size(); i++)
        if (in[i] && find(group, shapes[i].body) == g) mine.push_back((int)i);
      std::vector<char> moves(m.nbody, 0), stays(m.nbody, 0);
      for (int b = 1; b < m.nbody; b++) {
        moves[b] = body_in[b] && find(group, b) == g;
        stays[b] = find(whole, b) == main;
      }
      way_out(m, start, o, mine, moves, stays);
    }
  }
}

// The smallest displacement of a group of shapes that takes all of them out of an obstacle: `moves` says
// (per body) whose joints go with them, `stays` which joints are on the right side already.
void World::way_out(const Model& m, Poses& start, const Obstacle& o, const std::vector<int>& group,
                    const std::vector<char>& moves, const std::vector<char>& stays) {
  const std::vector<Vec3>& x = start.kin.xpos;
  const bool person = shapes[group[0]].person >= 0;
  auto right_side = [&](Vec3 shift) {
    if (o.thing) return true;
    for (int i : group) {
      const Vec3 c = place(start, i).center, j = x[shapes[i].body];
      // A hull stays on the side of its joint, a thing on its own.
      if (person ? o.crosses(j + shift, c + shift) : !o.crosses(c, c) && o.crosses(c, c + shift))
        return false;
    }
    for (int b = 1; b < m.nbody && person; b++) {
      if (m.root[b] != m.root[shapes[group[0]].body]) continue;
      // What goes stays connected with what does not, and nobody is taken through to another side.
      if (moves[b] && stays[b] && !o.crosses(x[b], x[b]) && o.crosses(x[b], x[b] + shift)) return false;
      const int p = m.parent[b];
      if (b == m.root[b] || moves[b] == moves[p]) continue;
      if (o.crosses(moves[p] ? x[p] + shift : x[p], moves[b] ? x[b] + shift : x[b])) return false;
    }
    return true;
  };
  // Nobody is to come out of one thing into another, nor to take there what hangs between it and the root.
  std::vector<char> between(m.nbody, 0);
  for (int i : group)
    for (int b = shapes[i].body; b > 0; b = m.parent[b]) between[b] = 1;
  std::vector<std::pair<int, Obstacle>> free;  // who is clear of what
  for (int i = 0; i < (int)shapes.size() && person; i++)
    for (const Static& s : statics) {
      if (!between[shapes[i].body] || pairing(shapes[i].name, s.name).ignore) continue;
      Obstacle other;
      other.fixed = &s;
      Box3 near = place(start, i).box;
      near.grow(kFarthest);
      if (other.meets(near) && clear_of(start, i, other, {}, kTouch)) free.push_back({i, other});
    }
  auto into_another = [&](Vec3 shift) {
    for (const auto& [i, other] : free)
      if (!clear_of(start, i, other, shift, kTouch)) return true;
    return false;
  };
  size_t last = 0;  // who was in the way last is so again
  bool anywhere = false;
  auto fits = [&](Vec3 shift) {
    for (size_t k = 0; k < group.size(); k++) {
      const size_t i = (last + k) % group.size();
      if (clear_of(start, group[i], o, shift, kClear)) continue;
      last = i;
      return false;
    }
    return right_side(shift) && (anywhere || !into_another(shift));
  };
  std::vector<Vec3> ways;
  if (o.is(Static::Kind::HalfSpace)) {
    add_way(ways, o.fixed->n);
  } else if (o.is(Static::Kind::Mesh)) {
    const TriangleTree& tree = *o.fixed->tree;
    std::vector<Plane> planes;
    for (int i : group) {
      planes.clear();
      tree.planes(place(start, i), kLook, planes);
      for (const Plane& p : planes) {
        Vec3 v[3];
        tree.triangle(p.triangle, v);
        const Vec3 n = cross(v[1] - v[0], v[2] - v[0]);
        add_way(ways, n), add_way(ways, -n);
      }
    }
  } else {
    for (Vec3 n : o.hull().shape->normals) add_way(ways, o.hull().R * n);
  }
  if (!o.is(Static::Kind::HalfSpace))
    for (int k = 0; k < 27; k++)
      add_way(ways, {(double)(k % 3 - 1), (double)(k / 3 % 3 - 1), (double)(k / 9 - 1)});
  double best = kFarthest;
  Vec3 exit;
  auto search = [&]() {
    for (Vec3 w : ways) {
      if (dot(w, avoid_) > kOtherWay) continue;
      double bad = 0, good = -1;
      for (double t = kStride; t < best + kStride && good < 0; t += kStride)
        (fits(t * w) ? good : bad) = t;
      if (good < 0 || bad >= best) continue;
      for (int k = 0; k < kBisections; k++) {
        const double t = 0.5 * (good + bad);
        (fits(t * w) ? good : bad) = t;
      }
      if (good < best) best = good, exit = good * w;
    }
  };
  search();
  if (norm2(exit) == 0) anywhere = true, search();
  for (int i : group) {
    if (is_inside(i, o.other_static, o.other_shape)) continue;  // on another way out already
    Inside in;
    in.shape = i, in.other_static = o.other_static, in.other_shape = o.other_shape;
    in.exit = exit;
    in.lost = norm2(exit) == 0;
    // Whoever is less deep than others of its group is held where it first is clear.
    double bad = 1;
    for (double out = 0; !in.lost; out += kStride / best) {
      if (out >= 1 || !clear_of(start, i, o, (1 - out) * exit, kClear)) {
        bad = std::min(out, 1.0);
        break;
      }
      in.out = out;
    }
    for (int k = 0; k < kBisections && !in.lost; k++) {
      const double out = 0.5 * (in.out + bad);
      (clear_of(start, i, o, (1 - out) * exit, kClear) ? in.out : bad) = out;
    }
    inside_.push_back(in);
  }
}

// What holds a shape that is on its way out: planes of the static against the displaced shape, and how
// much of its way it comes in this substep.
void World::gather_inside(Poses& start, BroadPhasePair& e, Inside& in, double reach, double h,
                          std::vector<ContactCandidate>& out) {
  in.next = in.out;
  e.dist = BroadPhasePair().dist;
  e.reach = 0;
  const Static* fixed = in.other_static >= 0 ? &statics[in.other_static] : nullptr;
  const PosedShape* hull = !fixed ? &place(start, in.other_shape)
                       : fixed->kind == Static::Kind::Hull ? &fixed->placed
                                                           : nullptr;
  if (in.lost) {
    Obstacle o;
    o.fixed = fixed, o.thing = fixed ? nullptr : hull;
    if (o.clear(place(start, in.shape), kLeastGap)) in.next = 1;
    return;
  }
  // Slower towards the end: what comes out fast overshoots.
  const double length = norm(in.exit),
               ease = std::min(1.0, std::max(kLeastPace, in.depth() / kEase)),
               pace = growth * ease * settings.depenetration_speed * h;
  const double r = reach + pace + kAhead;
  const PosedShape a = displaced(place(start, in.shape), (1 - in.out) * in.exit);
  if (hull) {
    const Separation s = separate(a, *hull, r, true, e.axis);
    e.axis = s.n;
    e.planes = {{s.n, hull->highest(s.n), s.dist, -1, false}};
  } else if (fixed->kind == Static::Kind::HalfSpace) {
    e.planes = {{fixed->n, fixed->offset, a.lowest(fixed->n) - fixed->offset, -1, false}};
  } else {
    fixed->tree->planes(a, r, e.planes);
  }
  double most = (pace + kAhead) / length;
  for (const Plane& p : e.planes) {
    const double closing = dot(p.n, in.exit);
    if (p.dist <= r && closing > 1e-9)
      most = std::min(most, (std::max(0.0, p.dist - kLeastGap) + pace) / closing);
  }
  in.pace = ease * settings.depenetration_speed * h;
  in.next = std::min(1.0, in.out + most);
  ContactCandidate c;
  c.shape = e.shape;
  c.other_static = e.other_static;
  c.other_shape = e.other_shape;
  c.inside = (int)(&in - inside_.data());
  c.from = (1 - in.out) * in.exit;
  c.to = (1 - in.next) * in.exit;
  for (const Plane& p : e.planes) {
    if (p.dist > r || p.overlaps) continue;
    take(c, p, h, out);
  }
}

void World::reroute(const Model& m, Poses& start) {
  const auto stuck = std::find_if(inside_.begin(), inside_.end(),
                                  [](const Inside& in) { return in.stuck >= kPatience; });
  if (stuck == inside_.end()) return;
  // Its whole group takes the other way.
  const Inside first = *stuck;
  std::vector<Inside> kept;
  std::vector<Overlap> overlaps;
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
  find_inside(m, start, overlaps);
  avoid_ = {};
  bool found = true;
  for (size_t k = kept.size(); k < inside_.size(); k++) found &= !inside_[k].lost;
  if (!found) inside_ = before;
  for (Inside& in : inside_) in.stuck = std::min(in.stuck, found ? in.stuck : 0);
  has_list_ = false;
}

void World::come_out(const std::vector<double>& share) {
  for (Inside& in : inside_) {
    const int b = shapes[in.shape].body;
    if (!active[b]) continue;
    const double got = in.next - in.out, slow = kSlow * norm(in.exit) * got;
    in.stuck = in.lost || slow >= in.pace ? 0 : in.stuck + 1;
    in.out += (share.empty() ? 1 : std::max(0.0, share[b])) * (in.next - in.out);
    in.next = in.out;
  }
  auto done = [](const Inside& in) { return in.out >= 1; };
  inside_.erase(std::remove_if(inside_.begin(), inside_.end(), done), inside_.end());
}

}  // namespace hp
