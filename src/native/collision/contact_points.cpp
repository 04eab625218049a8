#include "collision/contact_points.h"

#include <algorithm>
#include <cmath>
#include <functional>

#include "collision/overhang.h"
#include "geometry/contact_manifold.h"
#include "geometry/separation.h"
#include "tuning.h"

namespace hp {

namespace tune = tuning::collision;

namespace {

// The contact points of one candidate in one pass.
struct Generator {
  const CollisionWorld& world;
  const std::vector<CachedContact>& cached;
  Poses &start, &end;
  const ContactCandidate& c;
  int index, pass;
  std::vector<Contact>& contacts;
  const CollisionShape& shape;
  const PosedShape& a0;  // the shape at the start
  int already = 0;       // points that the candidate has
  Overhang& overhang;

  Generator(const CollisionWorld& world, const std::vector<CachedContact>& cached, Poses& start,
            Poses& end, const ContactCandidate& c, int index, int pass,
            std::vector<Contact>& contacts, Overhang& overhang)
      : world(world),
        cached(cached),
        start(start),
        end(end),
        c(c),
        index(index),
        pass(pass),
        contacts(contacts),
        shape(world.shapes[c.shape]),
        a0(world.place(start, c.shape)),
        overhang(overhang) {
    for (const Contact& k : contacts) already += k.pair == index;
  }

  void add();

 private:
  struct RimPoint {
    double gap;
    int feature;
    Vec3 toward;  // from the disc's centre
    bool operator<(const RimPoint& o) const {
      return gap < o.gap || (gap == o.gap && feature < o.feature);
    }
  };

  void make(Vec3 n, double dist, Vec3 xa, Vec3 xb, int feature, double back = 0);
  void make_opposite(Vec3 n, double dist, Vec3 xa, Vec3 xb, int feature);
  Endpoint endpoint(int which, Vec3 x, Vec3 measured, int feature, Material& gap);
  bool has(int v) const {
    return std::any_of(contacts.begin(), contacts.end(),
                       [&](const Contact& k) { return k.pair == index && k.feature == v; });
  }
  void add_vertex(int v);
  bool add_recalled_vertices();
  void add_deepest_vertices();
  std::vector<RimPoint> deep_rim_points() const;
  void add_rim_points();
  int rim_contact(int feature, Vec3 toward) const;
  void add_displaced();
  void add_first();
  void add_beside();
  void add_cached(bool& nearest);
  void add_at_end();
  void replace(int at);
  // A material point of a shape, at x at pose `at`: where it is at the start.
  Vec3 start_of(int which, Poses& at, Vec3 x) {
    const CollisionShape& own = world.shapes[which];
    return start.position(own, world.place(start, which),
                          at.material(own, world.place(at, which), x));
  }
};

// Appends a contact of the points xa and xb, whose gap along n is `dist`. Rounded surfaces lie
// `reach` before the points that they are round about, and points between two surfaces `back`
// before those.
void Generator::make(Vec3 n, double dist, Vec3 xa, Vec3 xb, int feature, double back) {
  Contact k;
  k.n = n;
  tangents(n, k.t, k.s);
  k.dist = dist;
  k.target = c.target;
  k.closing = dot(n, c.from - c.to);
  k.shift = k.closing;
  k.position = 0.5 * (xa + xb);
  k.at_a = xa, k.at_b = xb;
  k.a = endpoint(c.shape, xa, xa + (a0.reach(n) + back) * n, feature, k.gap_a);
  if (c.other_shape >= 0)
    k.b = endpoint(c.other_shape, xb, xb - (world.place(start, c.other_shape).reach(n) + back) * n,
                   feature, k.gap_b);
  const int other =
      c.other_static >= 0 ? world.statics[c.other_static].name : world.shapes[c.other_shape].name;
  const Pairing& pair = world.pairing(shape.name, other);
  k.friction = c.overlap >= 0 || world.overlaps_itself(c) ? 0 : pair.friction;
  k.restitution = c.overlap < 0 ? pair.restitution : 0;
  k.pair = index;
  k.key = pair_key(c);
  k.feature = feature;
  contacts.push_back(k);
}

// The bodies that carry a point x of a shape, and the material point whose gap counts: `measured`,
// the centre of a round surface. Bodies that do not take part count as the world.
Endpoint Generator::endpoint(int which, Vec3 x, Vec3 measured, int feature, Material& gap) {
  const CollisionShape& own = world.shapes[which];
  const PosedShape& at = world.place(start, which);
  const bool corner = own.skin && c.other_static >= 0;  // of a skin: one of its vertices
  const Material point = corner ? Material{feature, {}} : start.material(own, at, x);
  // What is measured of a skin moves with what is pushed.
  if (corner)
    gap = point;
  else if (own.skin)
    gap = start.of_vertex(own, at, point.vertex, measured);
  else
    gap = start.material(own, at, measured);
  return world.active[own.body] ? start.endpoint(own, at, point) : Endpoint{};
}

// Points that lie opposite each other act on one point between them: the angular momentum of the
// two is kept too.
void Generator::make_opposite(Vec3 n, double dist, Vec3 xa, Vec3 xb, int feature) {
  Vec3 x = 0.5 * (xa + xb);
  make(n, dist, x, x, feature, 0.5 * dist);
}

// The contact that was made last takes the place of contacts[at], and its impulse.
void Generator::replace(int at) {
  contacts.back().impulse = contacts[at].impulse;
  contacts[at] = contacts.back();
  contacts.pop_back();
}

void Generator::add_vertex(int v) {
  const Vec3 surface = a0.points().at(v) - shape.hull.radius * c.n;
  make(c.n, dot(c.n, surface + c.from) - c.offset, surface, surface, v);
}

// Vertices that carried an impulse in the substep before; false if there are none.
bool Generator::add_recalled_vertices() {
  bool any = false;
  for (const CachedContact& w : cached)
    if (w.candidate == index) {
      any = true;
      if (!has(w.feature)) add_vertex(w.feature);
    }
  return any;
}

void Generator::add_deepest_vertices() {
  const Points p0 = a0.points(), p1 = world.place(end, c.shape).points();
  std::vector<std::pair<double, int>> worst;
  for (int v = 0; v < p1.n; v++) {
    double gap = dot(c.n, p1.at(v) + c.shift()) - shape.hull.radius - c.offset;
    if (gap < c.target) worst.push_back({gap, v});
  }
  // A heap instead of sorting: a few of many are taken.
  auto later = std::greater<std::pair<double, int>>();
  std::make_heap(worst.begin(), worst.end(), later);
  int added = 0;
  std::vector<Vec3> chosen;
  while (!worst.empty()) {
    if (added == tune::kPointsPerPass || already + added == tune::kMostPoints) break;
    std::pop_heap(worst.begin(), worst.end(), later);
    const int v = worst.back().second;
    worst.pop_back();
    bool skip = has(v);
    if (already == 0)
      for (Vec3 o : chosen) skip |= norm2(o - p0.at(v)) < tune::kSpread2;
    if (skip) continue;
    chosen.push_back(p0.at(v));
    added++;
    add_vertex(v);
  }
}

// Points on the rims of the shape's discs that would end too near, deepest first.
std::vector<Generator::RimPoint> Generator::deep_rim_points() const {
  const Support s1 = world.place(end, c.shape).support();
  Vec3 t, s;
  tangents(c.n, t, s);
  std::vector<RimPoint> worst;
  for (int v = 0; v < s1.points.n; v++) {
    const Vec3 toward[5] = {s1.on_rim(-c.n), t, s, -t, -s};
    for (int k = 0; k < 5; k++) {
      // The last four are for a disc that lies flat; on its edge some would be nowhere in
      // particular.
      if (k > 0 && std::fabs(dot(toward[k], s1.axis)) > tune::kOnEdge) continue;
      Vec3 out = s1.on_rim(toward[k]);
      double gap = dot(c.n, s1.points.at(v) + c.shift() + out) - a0.hull->radius - c.offset;
      if (gap < c.target && norm2(out) > 0) worst.push_back({gap, 5 * v + k, toward[k]});
    }
  }
  std::sort(worst.begin(), worst.end());
  return worst;
}

// The contact of this disc's rim in nearly the same direction; -1: none.
int Generator::rim_contact(int feature, Vec3 toward) const {
  int same = -1;
  for (size_t i = 0; i < contacts.size(); i++) {
    const Contact& k = contacts[i];
    if (k.pair == index && k.feature == feature && norm(k.rim - toward) < tune::kSameRim)
      same = (int)i;
  }
  return same;
}

void Generator::add_rim_points() {
  const Support s0 = a0.support();
  std::vector<Vec3> chosen;
  int added = 0;
  for (const RimPoint& w : deep_rim_points()) {
    if (added == tune::kPointsPerPass || already + added == tune::kMostPoints) break;
    const Vec3 toward = (1 / norm(w.toward)) * w.toward;
    const Vec3 x = s0.points.at(w.feature / 5) + s0.on_rim(toward) - a0.hull->radius * c.n;
    const int same = rim_contact(w.feature, toward);
    if (same >= 0 && norm(contacts[same].rim - toward) < tune::kSettledRim) continue;
    const auto near = [x](Vec3 o) { return norm2(o - x) < tune::kSpread2; };
    if (already == 0 && std::any_of(chosen.begin(), chosen.end(), near)) continue;
    chosen.push_back(x);
    make(c.n, dot(c.n, x + c.from) - c.offset, x, x, w.feature);
    contacts.back().rim = toward;
    if (same >= 0)
      replace(same);
    else
      added++;
  }
}

// The nearest points of the displaced shape and the object, at the start or, later, at the end;
// they act where the shape is.
void Generator::add_displaced() {
  if (already == tune::kMostPoints) return;
  Poses& at = already == 0 ? start : end;
  const Vec3 shift = already == 0 ? c.from : c.shift();
  const Separation s = separate(displaced(world.place(at, c.shape), shift),
                                world.place(at, c.other_shape), 1e300, true, c.n);
  const bool settle = already > 0 && (pass > tune::kTurningPasses || s.dist <= 0 ||
                                      dot(s.n, c.n) < tune::kSameSide);
  const Vec3 n = settle ? c.n : s.n;
  const Vec3 xa = start_of(c.shape, at, s.pa - shift), xb = start_of(c.other_shape, at, s.pb);
  for (const Contact& k : contacts)
    if (k.pair == index && norm2(k.at_a - xa) < tune::kSamePoint2 &&
        dot(k.n, n) > tune::kSamePassNormal)
      return;
  make(n, dot(n, xa + c.from - xb), xa, xa, 5 + already);
  contacts.back().gap_b =
      start.material(world.shapes[c.other_shape], world.place(start, c.other_shape), xb);
}

// An object that sticks out over an edge of a static: the corners of what is carried, then the
// nearest points.
void Generator::add_beside() {
  for (const Contact& k : contacts)
    if (k.key == pair_key(c)) return add_at_end();
  Vec3 pa[Overhang::kMostCorners], pb[Overhang::kMostCorners];
  const int n = overhang.corners(start, c, pa, pb);
  for (int i = 0; i < n; i++)
    make_opposite(c.n, std::max(c.dist, dot(c.n, pa[i] - pb[i])), pa[i], pb[i], i);
  if (n == 0) add_at_end();
}

// Points that carried an impulse in the substep before, as long as they face each other. Points of round
// things on things are found anew: what rolls leaves them behind, and borne there it would roll by itself.
void Generator::add_cached(bool& nearest) {
  const CollisionShape& other = world.shapes[c.other_shape];
  const auto round = [](const Convex& hull) { return hull.radius > 0 || hull.rim > 0; };
  // (In hands and under feet they stay: grips are steadier with them.)
  const bool things = shape.person < 0 && other.person < 0;
  if (things && (round(shape.hull) || round(other.hull))) return;
  const PosedShape& b0 = world.place(start, c.other_shape);
  for (const CachedContact& w : cached) {
    if (w.key != pair_key(c) || dot(w.normal, c.n) < tune::kCachedNormal) continue;
    Vec3 xa = start.position(shape, a0, w.point), xb = start.position(other, b0, w.other);
    double gap = dot(c.n, xa - xb);
    if (norm2(xa - xb - gap * c.n) > tune::kSamePoint2 || gap < c.dist - tune::kFlat) continue;
    make_opposite(c.n, std::max(c.dist, gap), xa, xb, w.feature);
    nearest |= gap < c.dist + tune::kFlat;
  }
}

void Generator::add_first() {
  const PosedShape& b0 = world.place(start, c.other_shape);
  Vec3 pa[4], pb[4];
  bool nearest = false;  // one of the points is as near as the two shapes are
  const size_t first = contacts.size();
  add_cached(nearest);
  // What carried something in the substep before mostly does so again; what it does not hold is added in
  // view of the end pose. Corners are sought where nothing is known yet.
  const bool recalled =
      contacts.size() > first && std::any_of(cached.begin(), cached.end(),
                                             [&](const auto& w) { return w.candidate == index; });
  auto known = [&](Vec3 xa, Vec3 xb) {
    for (size_t k = first; k < contacts.size(); k++)
      if (norm2(contacts[k].position - 0.5 * (xa + xb)) < tune::kSamePoint2) return true;
    return false;
  };
  const int n = recalled ? 0 : face_manifold(a0, b0, c.n, tune::kFaceThickness, 4, pa, pb);
  for (int i = 0; i < n; i++) {
    double gap = std::max(c.dist, dot(c.n, pa[i] - pb[i]));
    nearest |= gap < c.dist + tune::kFlat;
    if (!known(pa[i], pb[i])) make_opposite(c.n, gap, pa[i], pb[i], i);
  }
  // The corners of a slanted face need not be where the two are nearest.
  if ((n < 3 && !recalled) || !nearest) {
    Separation s{c.dist, c.n, c.pa, c.pb};
    if (c.dist <= 0) s = separate_along(a0, b0, c.n);
    if (!known(s.pa, s.pb)) make_opposite(c.n, c.dist, s.pa, s.pb, 4);
  }
}

// The point of a shape farthest along a normal.
Vec3 top(const PosedShape& s, Vec3 n) { return s.support().farthest(n) + s.hull->radius * n; }

// Of two moving shapes, or of an object and a static that it sticks out over.
void Generator::add_at_end() {
  const PosedShape& a1 = world.place(end, c.shape);
  const bool fixed = c.other_static >= 0;
  Separation s = fixed ? overhang.at_end(start, end, c)
                       : separate(a1, world.place(end, c.other_shape), 1e300, false, c.n);
  const bool settle = pass > tune::kTurningPasses || s.dist <= 0 || dot(s.n, c.n) < tune::kSameSide;
  if (settle) {
    s.n = c.n;
    s.pa = top(a1, -c.n);
    s.pb = fixed ? s.pa - (dot(c.n, s.pa) - c.offset) * c.n
                 : top(world.place(end, c.other_shape), c.n);
  }
  // The same material points at the start, and how far apart they were along the end's normal: a
  // better line for the contact that is there, or one more.
  const Vec3 xa = start_of(c.shape, end, s.pa);
  const Vec3 xb = fixed ? s.pb : start_of(c.other_shape, end, s.pb);
  const double dist = dot(s.n, xa - xb);
  auto sphere = [](const PosedShape& x) { return x.hull->radius > 0 && x.points().n == 1; };
  const bool round = !fixed && sphere(a1) && sphere(world.place(end, c.other_shape));
  int same = -1;
  for (size_t i = 0; i < contacts.size(); i++) {
    const Contact& k = contacts[i];
    if (k.pair == index && (round || (norm2(k.at_a - xa) < tune::kSamePoint2 &&
                                      norm2(k.at_b - xb) < tune::kSamePoint2)))
      same = (int)i;
  }
  if (same >= 0 && settle && dot(contacts[same].n, s.n) > 1 - 1e-9)
    return;  // only its shift is missing
  if (same < 0 && already == tune::kMostPoints) return;
  const int feature = same >= 0 ? contacts[same].feature : 5 + already;
  settle ? make(s.n, dist, xa, xb, feature) : make_opposite(s.n, dist, xa, xb, feature);
  if (same >= 0) replace(same);
}

void Generator::add() {
  if (c.other_static >= 0) {
    if (overhang.any(start, end, c))
      add_beside();
    else if (shape.hull.rim > 0)
      add_rim_points();
    else if (pass > 0 || already > 0 || !add_recalled_vertices())
      add_deepest_vertices();
  } else if (c.overlap >= 0) {
    add_displaced();
  } else if (already == 0) {
    add_first();
  } else {
    add_at_end();
  }
}

}  // namespace

void ContactPoints::add(const std::vector<CachedContact>& cached, Poses& start, Poses& end,
                        const ContactCandidate& c, int index, int pass,
                        std::vector<Contact>& contacts) const {
  Generator(world_, cached, start, end, c, index, pass, contacts, overhang_).add();
}

// The point of a disc's rim that lies in the contact's direction, whatever material that is.
double ContactPoints::rim_gap_at(Poses& start, Poses& end, const Contact& c, int shape) const {
  const CollisionShape& M = world_.shapes[shape];
  const int b = M.body;
  auto on_rim = [&](const Poses& p) {
    return Support{{}, p.kin.xmat[b] * M.hull.axis, M.hull.rim}.on_rim(c.rim);
  };
  Vec3 from = on_rim(start), center = c.at_a - from;
  const Material hub{-1, mul_t(start.kin.xmat[b], center - start.kin.xpos[b])};
  return c.dist - c.closing +
         dot(c.n, end.position(M, world_.place(end, shape), hub) + on_rim(end) - center - from);
}

double ContactPoints::gap_at(Poses& start, Poses& end, const Contact& c) const {
  const PairId k = pair_of_key(c.key);
  if (norm2(c.rim) > 0) return rim_gap_at(start, end, c, k.shape);
  auto moved = [&](int shape, const Endpoint& e, const Material& point) {
    if (e.count == 0) return Vec3{};  // it does not take part
    const CollisionShape& M = world_.shapes[shape];
    return end.position(M, world_.place(end, shape), point) -
           start.position(M, world_.place(start, shape), point);
  };
  Vec3 way = moved(k.shape, c.a, c.gap_a);
  if (k.other_shape >= 0) way -= moved(k.other_shape, c.b, c.gap_b);
  return c.dist - c.closing + dot(c.n, way);
}

}  // namespace hp
