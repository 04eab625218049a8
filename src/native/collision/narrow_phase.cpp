#include "collision/narrow_phase.h"

#include <limits>

namespace hp {

namespace {

constexpr double kGiveWay = 0.05;   // speed at which a clearance that was lost is regained [m/s]
constexpr double kTouch = 1e-5;     // overlaps up to this at the start are contacts at rest [m]
constexpr double kDeeper = 0.3;     // who leaves itself may get deeper by this share of the speed out
constexpr double kAhead = 0.02;  // looked this much farther than asked, to know of the next [m]
// A step that would end nearer than half of kLeastGap (or of the distance it starts from) is
// shortened; under the first of these it may only wear the gap away as slowly as solving is exact,
// under the second not at all [m].
constexpr double kFloor = 2e-5, kLastFloor = 5e-6;

// Corners of the polygon around a disc, from its centre: the same material points at every pose.
constexpr int kRimSides = 32;
Vec3 rim_corner(const PosedShape& s, int k) {
  Vec3 t, b;
  tangents(s.shape->axis, t, b);
  double angle = 2 * M_PI * k / kRimSides, r = s.shape->rim / std::cos(M_PI / kRimSides);
  return s.R * (r * (std::cos(angle) * t + std::sin(angle) * b));
}

}  // namespace

void World::start_poses(Poses& p) const {
  p.stamp = ++stamps_;
  p.placed.resize(shapes.size());
  p.fresh.assign(shapes.size(), 0);
  p.bends.clear();
  p.balls.clear();
}

const PosedShape& World::place(Poses& p, int i) const {
  if (!p.fresh[i]) p.place(shapes, i);
  return p.placed[i];
}

bool World::may_touch(const Model& m, int a, int b) const {
  const CollisionShape &A = shapes[a], &B = shapes[b];
  if (m.root[A.body] == m.root[B.body] && !may_touch_itself(a, b)) return false;
  return !pairing(A.name, B.name).ignore;
}

void World::demand(ContactCandidate& c, double h) {
  // What comes out is held at a distance that leaves it room.
  double clear = c.inside >= 0 ? kLeastGap : settings.clearance;
  auto it = pairs_.find(key(c));
  if (it != pairs_.end() && c.inside < 0) {
    if (c.dist >= clear) {
      pairs_.erase(it);
    } else {
      clear = std::min(clear, it->second.clearance);
    }
  }
  if (c.dist >= clear)
    c.target = clear;
  else if (c.dist >= 0)
    c.target = c.dist + std::min(clear - c.dist, kGiveWay * h);
  else if (it != pairs_.end() && it->second.kept)
    c.target = c.dist;
  else
    c.target = c.dist + std::min(pace_of(c) * settings.depenetration_speed * h, -c.dist);
  if (c.dist <= 0) {
    const bool own = c.other_shape >= 0 && may_touch_itself(c.shape, c.other_shape);
    c.hard = c.dist - (own ? kDeeper * settings.depenetration_speed * h : 1e-7);
    return;
  }
  c.hard = 0.5 * std::min(c.dist, kLeastGap);
  if (clear < 2 * kFloor) return;  // what rests nearer than that is not in danger
  c.hard = std::min(std::max(c.hard, kFloor),
                    std::max(c.dist - 2 * settings.tolerance, std::min(c.dist, kLastFloor)));
}

void World::take(ContactCandidate& c, const Plane& p, double h, std::vector<ContactCandidate>& out) {
  c.n = p.n;
  c.offset = p.offset;
  c.dist = p.dist;
  c.triangle = p.triangle;
  demand(c, h);
  out.push_back(c);
}

bool World::takes_part(const BroadPhasePair& e) const {
  const int a = shapes[e.shape].body;
  if (e.other_shape < 0) return active[a] && !asleep[a];
  const int b = shapes[e.other_shape].body;
  if (asleep[a] && asleep[b]) return false;
  return (active[a] && (active[b] || standing[b])) || (active[b] && standing[a]);
}

void World::gather(const Model& m, Poses& start, const std::vector<double>& reach, double h,
                   std::vector<ContactCandidate>& out) {
  out.clear();
  if (!exits_known_) find_exits(m, start);
  // A pair that overlaps leaves along the direction fixed when the overlap was first seen.
  // Fixed in the world; of two of one person, in the frame of the other, which may turn.
  auto fixed_exit = [&](ContactCandidate& c, const Mat3& frame, auto along) {
    auto it = pairs_.find(key(c));
    bool known = it != pairs_.end() && it->second.inside;
    if (c.dist >= 0) {
      if (known) it->second.inside = false;
    } else if (known) {
      c.n = frame * it->second.exit;
      along(c);
    } else {
      if (it == pairs_.end()) it = pairs_.insert({key(c), {settings.clearance, false, {}, false}}).first;
      it->second.inside = true;
      it->second.exit = mul_t(frame, c.n);
    }
  };
  for (BroadPhasePair& e : broad_pairs_) {
    if (!takes_part(e)) continue;
    double r = reach[e.shape] + (e.other_shape >= 0 ? reach[e.other_shape] : 0.0);
    if (any_inside())
      if (Inside* in = inside_of(e)) {
        gather_inside(start, e, *in, r, h, out);
        continue;
      }
    if (far(e, r)) continue;
    ContactCandidate c;
    c.shape = e.shape;
    c.other_static = e.other_static;
    c.other_shape = e.other_shape;
    const PosedShape& A = place(start, e.shape);
    if (e.other_static >= 0 && statics[e.other_static].kind == Static::Kind::HalfSpace) {
      const Static& S = statics[e.other_static];
      c.n = S.n;
      c.offset = S.offset;
      c.dist = A.lowest(S.n) - S.offset;
      e.dist = c.dist;
      e.way = way_of(e);
      if (c.dist > r) continue;
      demand(c, h);
      out.push_back(c);
      continue;
    }
    if (e.other_shape >= 0) {
      // People come first, so that the normal points into the part.
      const PosedShape& B = place(start, e.other_shape);
      auto known = pairs_.find(key(c));
      if (known != pairs_.end() && known->second.through) {
        Vec3 pa, pb;
        if (gjk(A.support(), B.support(), A.center - B.center, pa, pb) <= 0) continue;
        pairs_.erase(known);
      }
      if (e.own && spheres_apart(start, e, r)) continue;
      Separation s = separate(A, B, e.dist > r ? r + kAhead : r, true, e.axis, &e.hint);
      e.axis = s.n;
      e.dist = s.dist;
      e.way = way_of(e);
      if (s.dist > r) continue;
      c.n = s.n;
      c.dist = s.dist;
      c.hint = e.hint;
      if (e.own && c.dist < 0 && (known == pairs_.end() || !known->second.inside)) {
        c.n = least_overlap(A, B, c.n);
        c.dist = separate_along(A, B, c.n).dist;
      }
      fixed_exit(c, e.own ? start.kin.xmat[stays(m, c)] : Mat3{},
                 [&](ContactCandidate& k) { k.dist = separate_along(A, B, k.n).dist; });
      demand(c, h);
      out.push_back(c);
      continue;
    }
    if (behind_planes(e, A, r)) continue;
    // What was near is asked again anyhow.
    look(start, e, e.dist > r || e.dist == BroadPhasePair().dist ? r + kAhead : r);
    const Static& S = statics[e.other_static];
    if (S.kind == Static::Kind::Hull) {
      if (e.dist > r) continue;
      c.n = e.planes[0].n;
      c.dist = e.dist;
      fixed_exit(c, Mat3{}, [&](ContactCandidate& k) { k.dist = separate_along(A, S.placed, k.n).dist; });
      c.offset = S.placed.highest(c.n);
      demand(c, h);
      out.push_back(c);
      continue;
    }
    bool overlaps = false;
    for (const Plane& p : e.planes) overlaps |= p.overlaps;
    if (overlaps) continue;  // only a solver that failed can have let it in
    for (const Plane& p : e.planes) {
      if (p.dist > r) continue;
      take(c, p, h, out);
    }
  }
}

void World::reset(const Model& m, Poses& start) {
  pairs_.clear();
  inside_.clear();
  growth = 1;
  std::vector<double> reach(shapes.size(), settings.clearance);
  std::vector<ContactCandidate> near;
  list(m, start, reach);
  std::vector<Overlap> overlaps;
  for (BroadPhasePair& e : broad_pairs_) {
    bool inside = false;
    if (forced && shapes[e.shape].person >= 0) continue;
    if (e.other_shape >= 0) {
      const CollisionShape &A = shapes[e.shape], &B = shapes[e.other_shape];
      if (A.person < 0 || B.person >= 0) continue;  // of things that overlap: see fixed_exit
      if (separate(place(start, e.shape), place(start, e.other_shape)).dist < -kTouch)
        overlaps.push_back({e.shape, -1, e.other_shape});
      continue;
    }
    look(start, e, settings.clearance);
    if (statics[e.other_static].kind == Static::Kind::Mesh)
      for (const Plane& p : e.planes) inside |= p.overlaps;
    else
      inside = e.dist < -kTouch;
    if (inside) overlaps.push_back({e.shape, e.other_static, -1});
  }
  if (!overlaps.empty()) {
    find_inside(m, start, overlaps);
    has_list_ = false;  // who is cut off is listed too
    list(m, start, reach);
  }
  gather(m, start, reach, 1.0, near);
  waited_ = 0, depth_ = 1e300;
  if (self_contact()) leave_together(m, start);
  for (const ContactCandidate& c : near) {
    // What touches, to within rounding of files, rests there; what is deeper inside comes out.
    if (c.dist < -kTouch && c.other_shape >= 0 && shapes[c.shape].person >= 0 &&
        shapes[c.other_shape].person >= 0 &&
        m.root[shapes[c.shape].body] != m.root[shapes[c.other_shape].body])
      pairs_[key(c)].through = true;
    if (c.dist < -kTouch && c.other_shape >= 0 && shapes[c.shape].person < 0)
      pairs_[key(c)].kept = -c.dist <= shapes[c.shape].slack + shapes[c.other_shape].slack;
    if (c.inside >= 0 || c.dist < -kTouch || c.dist >= settings.clearance) continue;
    double own = std::max(c.dist, 0.0);
    auto [it, added] = pairs_.insert({key(c), {own, false, {}, false}});
    if (!added) it->second.clearance = std::min(it->second.clearance, own);
  }
}

// By how much the arcs of a shape's points bulge out of the hull of its start and end vertices, as
// seen by what turns by `back` meanwhile: r angle^2 / 8.
double World::bulge(int shape, const Poses& start, const Poses& end, const Mat3& back) const {
  const CollisionShape& M = shapes[shape];
  return M.most_of([&](const CollisionShape::Tie& t) {
    const Mat3 turn = back * (end.kin.xmat[t.body] * transposed(start.kin.xmat[t.body]));
    const double cosine = 0.5 * (turn.m[0] + turn.m[4] + turn.m[8] - 1),
                 angle = std::acos(std::min(1.0, std::max(-1.0, cosine)));
    return t.reach * angle * angle / 8;
  });
}

// Is the hull of the shape's start and end vertices, relative to the other, disjoint from it by
// the clearance? Then the plane between them says nothing.
bool World::swept_clear(const PosedShape& a0, const PosedShape& a1, const ContactCandidate& c, Poses& start,
                        Poses& end) const {
  if (c.dist < settings.clearance) return false;
  const bool disc = a0.shape->rim > 0;
  Points p0 = a0.points(), p1 = a1.points();
  int n = p0.n * (disc ? kRimSides : 1);
  std::vector<double> xyz(6 * (size_t)n);
  double *x = xyz.data(), *y = x + 2 * n, *z = y + 2 * n;
  Mat3 back;
  Vec3 shift;
  if (c.other_shape >= 0) {
    // Into the other's start frame: x -> R0 R1^T (x - p1) + p0.
    int b = shapes[c.other_shape].body;
    back = start.kin.xmat[b] * transposed(end.kin.xmat[b]);
    shift = start.kin.xpos[b] - back * end.kin.xpos[b];
  }
  // A disc is the polygon around it here.
  auto corner = [&](const PosedShape& s, Points p, int i) {
    return disc ? p.at(i / kRimSides) + rim_corner(s, i % kRimSides) : p.at(i);
  };
  for (int i = 0; i < n; i++) {
    Vec3 p = corner(a0, p0, i) + c.from, q = corner(a1, p1, i) + c.shift();
    if (c.other_shape >= 0) q = back * q + shift;
    x[i] = p.x, y[i] = p.y, z[i] = p.z;
    x[n + i] = q.x, y[n + i] = q.y, z[n + i] = q.z;
  }
  const Support swept{{x, y, z, 2 * n}};
  double margin = bulge(c.shape, start, end, back) + a0.shape->radius + settings.clearance;
  Vec3 pa, pb;
  if (c.other_static >= 0 && c.triangle >= 0) {
    Vec3 v[3];
    statics[c.other_static].tree->triangle(c.triangle, v);
    double tx[3] = {v[0].x, v[1].x, v[2].x}, ty[3] = {v[0].y, v[1].y, v[2].y},
           tz[3] = {v[0].z, v[1].z, v[2].z};
    return gjk(swept, Support{{tx, ty, tz, 3}}, c.n, pa, pb, margin) > margin;
  }
  const PosedShape& b =
      c.other_static >= 0 ? statics[c.other_static].placed : place(start, c.other_shape);
  margin += b.shape->radius;
  if (c.other_shape < 0 || !shapes[c.other_shape].skin)
    return gjk(swept, b.support(), c.n, pa, pb, margin) > margin;
  // A skin changes its shape on the way, seen from the frame it is carried in: both ends of it.
  const Points q0 = b.points(), q1 = place(end, c.other_shape).points();
  std::vector<double> other(6 * (size_t)q0.n);
  double *u = other.data(), *v = u + 2 * q0.n, *w = v + 2 * q0.n;
  for (int i = 0; i < q0.n; i++) {
    const Vec3 p = q0.at(i), q = back * q1.at(i) + shift;
    u[i] = p.x, v[i] = p.y, w[i] = p.z;
    u[q0.n + i] = q.x, v[q0.n + i] = q.y, w[q0.n + i] = q.z;
  }
  margin += bulge(c.other_shape, start, end, back);
  return gjk(swept, Support{{u, v, w, 2 * q0.n}}, c.n, pa, pb, margin) > margin;
}

// Is the same hull disjoint from the whole mesh? Then no plane of it that may be crossed hides
// anything. Asked once for each way: a part that flies by something finely divided crosses many.
bool World::mesh_clear(const ContactCandidate& c, Poses& start, Poses& end) const {
  const PosedShape &a0 = place(start, c.shape), &a1 = place(end, c.shape);
  if (a0.shape->rim > 0) return false;
  if (ways_of_ != end.stamp) ways_.clear(), ways_of_ = end.stamp;
  for (const Way& w : ways_)
    if (w.shape == c.shape && w.other_static == c.other_static) return w.clear;
  static thread_local Convex shape;
  static thread_local PosedShape swept;
  const int n = a0.points().n;
  shape.vertices.resize(2 * (size_t)n);
  swept.shape = &shape;
  swept.xyz.resize(6 * (size_t)n);
  for (int k = 0; k < 3; k++)
    for (int i = 0; i < n; i++) {
      swept.xyz[(size_t)k * 2 * n + i] = a0.xyz[(size_t)k * n + i] + c.from[k];
      swept.xyz[(size_t)k * 2 * n + n + i] = a1.xyz[(size_t)k * n + i] + c.shift()[k];
    }
  swept.center = 0.5 * (a0.center + c.from + a1.center + c.shift());
  swept.box = {};
  for (Vec3 p : {a0.box.lo + c.from, a0.box.hi + c.from, a1.box.lo + c.shift(), a1.box.hi + c.shift()})
    swept.box.add(p);
  const double margin = bulge(c.shape, start, end, {}) + a0.shape->radius + settings.clearance;
  const bool clear = statics[c.other_static].tree->distance(swept, margin) >= margin;
  ways_.push_back({c.shape, c.other_static, clear});
  return clear;
}

double World::excess(Poses& start, Poses& end, ContactCandidate& c) const {
  const PosedShape& a1 = place(end, c.shape);
  c.forgiven = false;
  bool half_space =
      c.other_static >= 0 && statics[c.other_static].kind == Static::Kind::HalfSpace;
  double gap;
  if (c.other_static >= 0) {
    gap = a1.lowest(c.n) + dot(c.n, c.shift()) - c.offset;
    if (half_space || gap >= c.target) return gap - c.target;
  } else {
    const PosedShape& b1 = place(end, c.other_shape);
    PosedShape moved;
    if (c.inside >= 0) moved = displaced(a1, c.shift());
    const PosedShape& a = c.inside >= 0 ? moved : a1;
    gap = separate_along(a, b1, c.n).dist;
    if (gap >= c.target || c.dist < 0) return gap - c.target;
    // The plane between two things turns as they do: where their nearest sides are still the
    // same, what counts is their distance at the end.
    Hint hint = c.hint;
    Separation s = separate(a, b1, 1e300, false, c.n, &hint);
    if (s.dist > 0 && dot(s.n, c.n) > 0.5) return s.dist - c.target;
  }
  if (swept_clear(place(start, c.shape), a1, c, start, end)) {
    c.forgiven = true;
    return 1e300;
  }
  return gap - c.target;
}

void World::search_behind(Poses& start, const std::vector<double>& reach, double h, int index,
                          std::vector<ContactCandidate>& all) {
  all[index].searched = true;
  ContactCandidate c = all[index];
  std::vector<int> without;
  for (const ContactCandidate& k : all)
    if (k.shape == c.shape && k.other_static == c.other_static && k.searched)
      without.push_back(k.triangle);
  std::vector<Plane> planes;
  for (const ContactCandidate& k : all)
    if (k.shape == c.shape && k.other_static == c.other_static && !k.searched)
      planes.push_back({k.n, k.offset, k.dist, k.triangle, false});
  statics[c.other_static].tree->planes(displaced(place(start, c.shape), c.from), reach[c.shape], planes,
                                       without);
  c.searched = c.forgiven = false;
  for (const Plane& p : planes) {
    bool known = false;
    for (const ContactCandidate& k : all)
      known |= k.shape == c.shape && k.other_static == c.other_static && k.triangle == p.triangle;
    if (known) continue;
    take(c, p, h, all);
  }
}

void World::save(std::vector<double>& out) const {
  out.push_back((double)pairs_.size());
  for (const auto& [k, s] : pairs_)
    out.insert(out.end(), {(double)(k >> 32), (double)(k & 0xffffffff), s.clearance,
                           s.inside ? 1.0 : 0.0, s.exit.x, s.exit.y, s.exit.z,
                           (s.through ? 1.0 : 0.0) + (s.kept ? 2.0 : 0.0)});
  out.push_back((double)inside_.size());
  for (const Inside& i : inside_)
    out.insert(out.end(), {(double)i.shape, (double)i.other_static, (double)i.other_shape, i.exit.x,
                           i.exit.y, i.exit.z, i.out, i.lost ? 1.0 : 0.0, (double)i.stuck});
  out.push_back(growth);
  save_near(out);
}

const double* World::load(const double* in) {
  pairs_.clear();
  for (int n = (int)*in++; n > 0; n--, in += 8)
    pairs_[((int64_t)in[0] << 32) | (int64_t)in[1]] = {in[2], in[3] != 0, load3(in + 4),
                                                       ((int)in[7] & 1) != 0, ((int)in[7] & 2) != 0};
  inside_.clear();
  for (int n = (int)*in++; n > 0; n--, in += 9)
    inside_.push_back({(int)in[0], (int)in[1], (int)in[2], load3(in + 3), in[6], in[6], in[7] != 0, 0,
                       (int)in[8]});
  growth = *in++;
  return load_near(in);
}

}  // namespace hp
