// People who touch themselves: which of their hulls may, and what need not be looked at.
//
// Distances between hulls of one person depend on the pose only, not on where the person is: what
// they travel is counted in the frame of the root, or nobody who walks could be left alone.
#include <cmath>

#include "collision/narrow_phase.h"

namespace hp {

namespace {

constexpr double kRounding = 1e-9;  // of distances [m]
constexpr double kMargin = 0.15;    // looked this much farther than asked, to know of the next [m]
// Directions that are tried for the least overlap, and how the best is turned to be better [rad].
constexpr int kDirections = 192, kRefinements = 40;
// Who gets no farther than to this share of the depth in so many substeps tries another way.
constexpr int kPatience = 24;
constexpr double kProgress = 0.9;
constexpr double kFirstTurn = 0.15, kLastTurn = 1e-4;

// The direction in which `apart` is largest.
template <typename Apart>
Vec3 best_direction(Apart apart, const std::vector<Vec3>& guesses) {
  Vec3 best;
  double most = -1e300;
  auto attempt = [&](Vec3 n) {
    const double length = norm(n);
    if (length < 1e-12) return false;
    n = (1 / length) * n;
    const double dist = apart(n);
    if (dist <= most) return false;
    most = dist, best = n;
    return true;
  };
  for (Vec3 n : guesses) attempt(n);
  const double golden = M_PI * (3 - std::sqrt(5.0));
  for (int k = 0; k < kDirections; k++) {
    const double z = 1 - (2 * k + 1.0) / kDirections, r = std::sqrt(1 - z * z);
    attempt({r * std::cos(golden * k), r * std::sin(golden * k), z});
  }
  double turn = kFirstTurn;
  for (int k = 0; k < kRefinements && turn > kLastTurn; k++) {
    Vec3 t, s;
    tangents(best, t, s);
    const Vec3 from = best;
    bool better = false;
    for (Vec3 d : {t, s, -t, -s, t + s, t - s, s - t, -t - s}) better |= attempt(from + turn * d);
    if (!better) turn *= 0.5;
  }
  return best;
}

}  // namespace

void World::set_self_pairs(const std::vector<std::pair<int, int>>& pairs) {
  self_.assign(pairs.empty() ? 0 : shapes.size() * shapes.size(), 0);
  for (const auto& [i, j] : pairs) self_[i * shapes.size() + j] = self_[j * shapes.size() + i] = 1;
}

double World::gap(Poses& p, int a, int b) const {
  const PosedShape &A = place(p, a), &B = place(p, b);
  const double dist = separate(A, B).dist;
  if (dist > 0) return dist;
  return separate_along(A, B, least_overlap(A, B, A.center - B.center)).dist;
}

void World::inner_ways(const Model& m, const Poses& from, const Poses& to,
                       std::vector<double>& way) const {
  way.clear();
  if (!self_contact()) return;
  static thread_local Poses inner[2];
  const Poses* poses[2] = {&from, &to};
  for (int k = 0; k < 2; k++) {
    const Kinematics& kin = poses[k]->kin;
    Kinematics& out = inner[k].kin;
    out.xpos.resize(m.nbody), out.xquat.resize(m.nbody), out.xmat.resize(m.nbody);
    for (int b = 1; b < m.nbody; b++) {
      const int r = m.root[b];
      if (!active[b]) continue;
      out.xpos[b] = mul_t(kin.xmat[r], kin.xpos[b] - kin.xpos[r]);
      out.xquat[b] = conjugate(kin.xquat[r]) * kin.xquat[b];
      out.xmat[b] = transposed(kin.xmat[r]) * kin.xmat[b];
    }
  }
  ways(shapes, inner[0], inner[1], active, way);
}

bool World::spheres_apart(Poses& p, BroadPhasePair& e, double r) const {
  const Poses::Ball &a = p.known_ball(shapes, e.shape), &b = p.known_ball(shapes, e.other_shape);
  const double dist = norm(a.center - b.center) - a.radius - b.radius;
  if (dist <= r) return false;
  e.dist = dist;
  e.way = way_of(e);
  return true;
}

// Both go straight, as seen from the root, but for their bulges: where the hulls of their ends are
// apart, so are they all the way.
bool World::meets_itself(const Model& m, Poses& start, Poses& end, const Sweep& sweep,
                         BroadPhasePair& e) const {
  const double clear = settings.clearance + kRounding,
               bulge = sweep.bulge[e.shape] + sweep.bulge[e.other_shape] + clear,
               r = sweep.inner[e.shape] + sweep.inner[e.other_shape] + bulge;
  if (far(e, r) || spheres_apart(start, e, r)) return false;
  const PosedShape &a = place(start, e.shape), &b = place(start, e.other_shape);
  const int root = m.root[shapes[e.shape].body];
  // What separated them last is likely to do so still, or all the way.
  if (norm2(e.axis) > 0) {
    const Vec3 n = (1 / norm(e.axis)) * e.axis;
    const double apart = a.lowest(n) - b.highest(n);
    if (apart > r) {
      e.dist = apart;
      e.way = way_of(e);
      return false;
    }
    if (apart > bulge) {
      const Vec3 then = end.kin.xmat[root] * mul_t(start.kin.xmat[root], n);
      if (place(end, e.shape).lowest(then) - place(end, e.other_shape).highest(then) > bulge) return false;
    }
  }
  const Separation s = separate(a, b, r + kMargin, false, e.axis);
  e.axis = s.n;
  e.dist = s.dist;
  e.way = way_of(e);
  if (s.dist > r) return false;
  if (s.dist <= bulge) return true;
  // Seen from the root, in its axes at the start.
  const Mat3 back = start.kin.xmat[root] * transposed(end.kin.xmat[root]);
  const Vec3 shift = start.kin.xpos[root] - back * end.kin.xpos[root];
  static thread_local std::vector<double> ends[2];
  auto swept = [&](int k, const PosedShape& from, const PosedShape& to) {
    const Points p = from.points(), q = to.points();
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
  const double margin = bulge + a.shape->radius + b.shape->radius;
  return gjk(swept(0, a, place(end, e.shape)), swept(1, b, place(end, e.other_shape)), s.n, pa, pb,
             margin) <= margin;
}

Vec3 World::least_overlap(const PosedShape& a, const PosedShape& b, Vec3 guess) {
  return best_direction([&](Vec3 n) { return a.lowest(n) - b.highest(n); },
                        {guess, a.center - b.center});
}

void World::choose_again(const Model& m, Poses& start) {
  if (++waited_ < kPatience) return;
  waited_ = 0;
  double depth = 0;
  for (const auto& [key, state] : pairs_) {
    const ContactCandidate c = unpacked(key);
    if (!state.inside || c.other_shape < 0 || !may_touch_itself(c.shape, c.other_shape)) continue;
    const Vec3 n = start.kin.xmat[stays(m, c)] * state.exit;
    const PosedShape &a = place(start, c.shape), &b = place(start, c.other_shape);
    depth += std::max(0.0, b.highest(n) - a.lowest(n));
  }
  if (depth > 0 && depth > kProgress * depth_) leave_together(m, start);
  depth_ = depth > 0 ? depth : 1e300;
}

// Pairs that start overlapping, and are neighbours on both sides, leave in one direction: a hand
// whose fingers went out before an arm while its palm went out behind would never get out.
void World::leave_together(const Model& m, Poses& start) {
  struct Pair {
    PairState* state;
    int shape, other, frame, group;
    double sign;
  };
  std::vector<Pair> all;
  for (auto& [key, state] : pairs_) {
    const ContactCandidate c = unpacked(key);
    if (!state.inside || c.other_shape < 0 || !may_touch_itself(c.shape, c.other_shape)) continue;
    all.push_back({&state, c.shape, c.other_shape, stays(m, c), (int)all.size(), 1});
  }
  auto neighbours = [&](int i, int j) {
    const int a = shapes[i].body, b = shapes[j].body;
    return a == b || m.parent[a] == b || m.parent[b] == a || m.parent[a] == m.parent[b];
  };
  for (size_t first = 0; first < all.size(); first++) {
    if (all[first].group != (int)first) continue;
    std::vector<size_t> group{first};
    for (size_t k = 0; k < group.size(); k++)
      for (size_t l = first + 1; l < all.size(); l++) {
        const Pair p = all[group[k]];
        Pair& q = all[l];
        if (q.group != (int)l) continue;
        const bool same = neighbours(p.shape, q.shape) && neighbours(p.other, q.other);
        if (!same && !(neighbours(p.shape, q.other) && neighbours(p.other, q.shape))) continue;
        q.group = (int)first, q.sign = same ? p.sign : -p.sign;
        group.push_back(l);
      }
    std::vector<Vec3> guesses;
    for (size_t k : group)
      guesses.push_back(all[k].sign *
                        (place(start, all[k].shape).center - place(start, all[k].other).center));
    const Vec3 n = best_direction(
        [&](Vec3 n) {
          double least = 1e300;
          for (size_t k : group) {
            const Vec3 d = all[k].sign * n;
            least = std::min(least,
                             place(start, all[k].shape).lowest(d) - place(start, all[k].other).highest(d));
          }
          return least;
        },
        guesses);
    for (size_t k : group)
      all[k].state->exit = mul_t(start.kin.xmat[all[k].frame], all[k].sign * n);
  }
}

}  // namespace hp
