// Where two that would come too near touch: contact points, and their gaps at the end pose.
#include <algorithm>
#include <cmath>
#include <functional>

#include "collision/narrow_phase.h"

namespace hp {

namespace {

constexpr int kTurningPasses = 3;
constexpr double kFlat = 1e-6;  // corners this much farther than the nearest point will do for it [m]
constexpr int kMostPoints = 16;  // of contact for one plane or pair
constexpr double kSamePoint2 = 2e-3 * 2e-3;  // points this near are one contact [m^2]
constexpr double kSpread2 = 5e-3 * 5e-3;     // of the first points, where there is a choice [m^2]
// Directions of the deepest point of a disc: up to the first [rad] it is one contact, which is
// turned; up to the second what it turns by costs nothing.
constexpr double kSameRim = 0.5, kSettledRim = 1e-4;

}  // namespace

// What a hand gave a thing in the substep before it is likely to give again. (Of what stands the points
// that would end deepest are wanted: those are not known without looking. And points between two things
// that nothing presses together would give a pile energy.)
bool World::recall(const std::vector<CachedContact>& remembered, const std::vector<ContactCandidate>& candidates,
                   std::vector<char>& out) const {
  out.assign(candidates.size(), 0);
  bool any = false;
  for (size_t i = 0; i < candidates.size(); i++) {
    const ContactCandidate& c = candidates[i];
    if (!handles(c) || c.inside >= 0) continue;
    for (const CachedContact& w : remembered) out[i] |= w.key == key(c);
    any |= out[i];
  }
  return any;
}

double World::gap_at(Poses& start, Poses& end, const Contact& c) const {
  const ContactCandidate k = unpacked(c.key);
  if (norm2(c.rim) > 0) {
    // On a disc against something that stands: the point of its rim that lies in that direction,
    // whatever material that is, so that what rolls or tips is measured where it touches.
    const CollisionShape& M = shapes[k.shape];
    const Convex& shape = M.shape;
    const int b = M.body;
    auto on_rim = [&](const Poses& p) {
      return Support{{}, p.kin.xmat[b] * shape.axis, shape.rim}.on_rim(c.rim);
    };
    Vec3 from = on_rim(start), center = c.at_a - from;
    const Material hub{-1, mul_t(start.kin.xmat[b], center - start.kin.xpos[b])};
    return c.dist - c.closing +
           dot(c.n, end.position(M, place(end, k.shape), hub) + on_rim(end) - center - from);
  }
  auto moved = [&](int shape, const Endpoint& e, const Material& point) {
    if (e.count == 0) return Vec3{};  // stands
    const CollisionShape& M = shapes[shape];
    return end.position(M, place(end, shape), point) - start.position(M, place(start, shape), point);
  };
  Vec3 way = moved(k.shape, c.a, c.gap_a);
  if (k.other_shape >= 0) way -= moved(k.other_shape, c.b, c.gap_b);
  return c.dist - c.closing + dot(c.n, way);
}

// Points on the rims of a shape's discs that would end too near what stands: the deepest, and four
// evenly turned ones, so that it stands on its face. They are points of the rim in a direction of
// the world, not of material: see gap_at.
template <typename Make>
void World::add_rim_contacts(const PosedShape& a0, const PosedShape& a1, const ContactCandidate& c, int index,
                             Make make, std::vector<Contact>& contacts) const {
  struct Point {
    double gap;
    int feature;
    Vec3 toward;
    bool operator<(const Point& o) const { return gap < o.gap || (gap == o.gap && feature < o.feature); }
  };
  const Support s0 = a0.support(), s1 = a1.support();
  const double r = a0.shape->radius;
  Vec3 t, s;
  tangents(c.n, t, s);
  std::vector<Point> worst;
  for (int v = 0; v < s1.points.n; v++) {
    const Vec3 toward[5] = {s1.on_rim(-c.n), t, s, -t, -s};
    for (int k = 0; k < 5; k++) {
      // The four are for a disc that lies flat; on its edge some would be nowhere in particular.
      if (k > 0 && std::fabs(dot(toward[k], s1.axis)) > 0.5) continue;
      Vec3 out = s1.on_rim(toward[k]);
      double gap = dot(c.n, s1.points.at(v) + c.shift() + out) - r - c.offset;
      if (gap < c.target && norm2(out) > 0) worst.push_back({gap, 5 * v + k, toward[k]});
    }
  }
  std::sort(worst.begin(), worst.end());
  int already = 0, added = 0;
  for (const Contact& k : contacts) already += k.pair == index;
  std::vector<Vec3> chosen;
  for (const Point& w : worst) {
    if (added == 4 || already + added == kMostPoints) break;
    Vec3 toward = (1 / norm(w.toward)) * w.toward;
    Vec3 x = s0.points.at(w.feature / 5) + s0.on_rim(toward) - r * c.n;
    int same = -1;
    for (size_t k = 0; k < contacts.size(); k++)
      if (contacts[k].pair == index && contacts[k].feature == w.feature &&
          norm(contacts[k].rim - toward) < kSameRim)
        same = (int)k;
    if (same >= 0 && norm(contacts[same].rim - toward) < kSettledRim) continue;
    bool near = false;
    for (Vec3 o : chosen) near |= norm2(o - x) < kSpread2;
    if (near && already == 0) continue;
    chosen.push_back(x);
    make(c.n, dot(c.n, x + c.from) - c.offset, x, x, w.feature);
    contacts.back().rim = toward;
    if (same >= 0) {
      contacts.back().impulse = contacts[same].impulse;
      contacts[same] = contacts.back();
      contacts.pop_back();
    } else {
      added++;
    }
  }
}

void World::add_contacts(const std::vector<CachedContact>& remembered, Poses& start, Poses& end,
                         const ContactCandidate& c, int index,
                         int pass, std::vector<Contact>& contacts) const {
  const CollisionShape& M = shapes[c.shape];
  const PosedShape& a0 = place(start, c.shape);
  int other_name =
      c.other_static >= 0 ? statics[c.other_static].name : shapes[c.other_shape].name;
  const Pairing& pair = pairing(M.name, other_name);
  // A contact of the points xa and xb, whose gap along n is `dist`; rounded surfaces end `round`
  // before the points that they are round about.
  auto make = [&](Vec3 n, double dist, Vec3 xa, Vec3 xb, int feature, double back = 0) {
    Contact k;
    k.n = n;
    tangents(n, k.t, k.s);
    k.dist = dist;
    k.target = c.target;
    k.closing = dot(n, c.from - c.to);
    k.shift = k.closing;
    k.position = 0.5 * (xa + xb);
    k.at_a = xa, k.at_b = xb;
    // Who stands is as good as the world. Round sides are measured at what they are round about.
    auto end_of = [&](int shape, Vec3 x, Vec3 counts, Material& gap) {
      const CollisionShape& own = shapes[shape];
      const PosedShape& at = place(start, shape);
      const bool corner = own.skin && c.other_static >= 0;  // of a skin: one of its vertices
      const Material point = corner ? Material{feature, {}} : start.material(own, at, x);
      gap = corner ? point : start.material(own, at, counts);
      Endpoint e = active[own.body] ? start.endpoint(own, at, point) : Endpoint{};
      return e;
    };
    k.a = end_of(c.shape, xa, xa + (a0.reach(n) + back) * n, k.gap_a);
    if (c.other_shape >= 0)
      k.b = end_of(c.other_shape, xb, xb - (place(start, c.other_shape).reach(n) + back) * n, k.gap_b);
    // What comes out of something slides out.
    const bool within = c.inside >= 0 || (c.dist < 0 && c.other_shape >= 0 &&
                                          may_touch_itself(c.shape, c.other_shape));
    k.friction = within ? 0 : pair.friction;
    k.restitution = c.inside < 0 ? pair.restitution : 0;
    k.pair = index;
    k.key = key(c);
    k.feature = feature;
    contacts.push_back(k);
  };
  // Points that lie opposite each other act on one point between them, so that the angular
  // momentum of the two is kept too.
  auto make_opposite = [&](Vec3 n, double dist, Vec3 xa, Vec3 xb, int feature) {
    Vec3 x = 0.5 * (xa + xb);
    make(n, dist, x, x, feature, 0.5 * dist);
  };
  int already = 0;
  for (const Contact& k : contacts) already += k.pair == index;
  if (c.other_static >= 0) {
    // The vertices that would end deepest; at first spread out, so that few carry a face.
    const PosedShape& a1 = place(end, c.shape);
    if (M.shape.rim > 0) {
      add_rim_contacts(a0, a1, c, index, make, contacts);
      return;
    }
    Points p0 = a0.points(), p1 = a1.points();
    double r = M.shape.radius;
    std::vector<std::pair<double, int>> worst;
    for (int v = 0; v < p1.n; v++) {
      double gap = dot(c.n, p1.at(v) + c.shift()) - r - c.offset;
      if (gap < c.target) worst.push_back({gap, v});
    }
    // A few of many: not worth sorting.
    auto later = std::greater<std::pair<double, int>>();
    std::make_heap(worst.begin(), worst.end(), later);
    int added = 0;
    std::vector<Vec3> chosen;
    while (!worst.empty()) {
      if (added == 4 || already + added == kMostPoints) break;
      std::pop_heap(worst.begin(), worst.end(), later);
      const int v = worst.back().second;
      worst.pop_back();
      Vec3 x = p0.at(v);
      bool skip = false;
      for (const Contact& k : contacts) skip |= k.pair == index && k.feature == v;
      if (already == 0)
        for (Vec3 o : chosen) skip |= norm2(o - x) < kSpread2;
      if (skip) continue;
      chosen.push_back(x);
      added++;
      Vec3 surface = x - r * c.n;
      make(c.n, dot(c.n, surface + c.from) - c.offset, surface, surface, v);
    }
    return;
  }
  const PosedShape& b0 = place(start, c.other_shape);
  if (c.inside >= 0) {
    // The nearest points of the displaced shape and the thing, at the start or, later, at the end; they
    // act where the shape is.
    if (already == kMostPoints) return;
    Poses& at = already == 0 ? start : end;
    const Vec3 shift = already == 0 ? c.from : c.shift();
    const Separation s =
        separate(displaced(place(at, c.shape), shift), place(at, c.other_shape), 1e300, true, c.n);
    const bool settle = already > 0 && (pass > kTurningPasses || s.dist <= 0 || dot(s.n, c.n) < 0.5);
    const Vec3 n = settle ? c.n : s.n;
    auto start_of = [&](int shape, Vec3 x) {
      const CollisionShape& own = shapes[shape];
      return start.position(own, place(start, shape), at.material(own, place(at, shape), x));
    };
    const Vec3 xa = start_of(c.shape, s.pa - shift), xb = start_of(c.other_shape, s.pb);
    for (const Contact& k : contacts)
      if (k.pair == index && norm2(k.at_a - xa) < kSamePoint2 && dot(k.n, n) > 0.9999) return;
    make(n, dot(n, xa + c.from - xb), xa, xa, 5 + already);
    contacts.back().gap_b = start.material(shapes[c.other_shape], b0, xb);
    return;
  }
  if (already == 0) {
    Vec3 pa[4], pb[4];
    bool nearest = false;
    const size_t first = contacts.size();
    // What carried something is likely to do so again: the same two points, as long as they face
    // each other.
    for (const CachedContact& w : remembered) {
      if (w.key != key(c) || dot(w.normal, c.n) < 0.99) continue;
      Vec3 xa = start.position(M, a0, w.point), xb = start.position(shapes[c.other_shape], b0, w.other);
      double gap = dot(c.n, xa - xb);
      if (norm2(xa - xb - gap * c.n) > kSamePoint2 || gap < c.dist - kFlat) continue;
      make_opposite(c.n, std::max(c.dist, gap), xa, xb, w.feature);
      nearest |= gap < c.dist + kFlat;
    }
    auto known = [&](Vec3 xa, Vec3 xb) {
      for (size_t k = first; k < contacts.size(); k++)
        if (norm2(contacts[k].position - 0.5 * (xa + xb)) < kSamePoint2) return true;
      return false;
    };
    int n = face_manifold(a0, b0, c.n, 2e-3, 4, pa, pb);
    // Each with its own gap: what stands at a slant must be free to lie down.
    for (int i = 0; i < n; i++) {
      double gap = std::max(c.dist, dot(c.n, pa[i] - pb[i]));
      nearest |= gap < c.dist + kFlat;
      if (!known(pa[i], pb[i])) make_opposite(c.n, gap, pa[i], pb[i], i);
    }
    // The corners of a slanted face need not be where the two are nearest.
    if (n < 3 || !nearest) {
      Separation s =
          c.dist > 0 ? separate(a0, b0, 1e300, true, c.n) : separate_along(a0, b0, c.n);
      if (!known(s.pa, s.pb)) make_opposite(c.n, c.dist, s.pa, s.pb, 4);
    }
    return;
  }
  const PosedShape &a1 = place(end, c.shape), &b1 = place(end, c.other_shape);
  // At first along the normal they would have at the end; where that does not settle, along the
  // one they start with: whatever is apart along any direction is apart.
  Separation s = separate(a1, b1, 1e300, false, c.n);
  bool settle = pass > kTurningPasses || s.dist <= 0 || dot(s.n, c.n) < 0.5;
  if (settle) {
    s.n = c.n;
    s.pa = a1.support().farthest(-c.n) - a1.shape->radius * c.n;
    s.pb = b1.support().farthest(c.n) + b1.shape->radius * c.n;
  }
  // The same material points at the start, and how far apart they were along the end's normal:
  // a better line for the contact that stands there, or one more.
  auto before = [&](int shape, Vec3 x) {
    const CollisionShape& own = shapes[shape];
    return start.position(own, place(start, shape), end.material(own, place(end, shape), x));
  };
  Vec3 xa = before(c.shape, s.pa), xb = before(c.other_shape, s.pb);
  double dist = dot(s.n, xa - xb);
  bool round = a1.shape->radius > 0 && a1.points().n == 1 && b1.shape->radius > 0 && b1.points().n == 1;
  Contact* same = nullptr;
  for (Contact& k : contacts)
    if (k.pair == index && (round || (norm2(k.at_a - xa) < kSamePoint2 &&
                                      norm2(k.at_b - xb) < kSamePoint2)))
      same = &k;
  if (same && settle && dot(same->n, s.n) > 1 - 1e-9) return;  // only its shift is missing
  if (!same && already == kMostPoints) return;
  const Contact old = same ? *same : Contact{};
  int at = same ? (int)(same - contacts.data()) : -1, feature = same ? old.feature : 5 + already;
  if (settle)
    make(s.n, dist, xa, xb, feature);
  else
    make_opposite(s.n, dist, xa, xb, feature);
  if (at < 0) return;
  contacts[at] = contacts.back();
  contacts.pop_back();
  contacts[at].impulse = old.impulse;
}

}  // namespace hp
