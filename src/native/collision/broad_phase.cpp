#include "collision/broad_phase.h"

#include <algorithm>
#include <cmath>

#include "geometry/separation.h"
#include "tuning.h"

namespace hp {

namespace tune = tuning::collision;

void BroadPhase::forget() {
  const size_t n = world_.shapes.size();
  pairs_.clear();
  listed_once_ = false;
  for (auto* v : {&travelled_, &listed_, &range_, &inner_}) v->assign(n, 0);
}

void BroadPhase::travel(const std::vector<double>& travel, const std::vector<double>& inner) {
  const std::vector<CollisionShape>& shapes = world_.shapes;
  for (size_t i = 0; i < shapes.size(); i++)
    if (world_.active[shapes[i].body]) travelled_[i] += travel[i];
  for (size_t i = 0; i < inner.size(); i++)
    if (world_.active[shapes[i].body]) inner_[i] += inner[i];
}

// Of all shapes, grown by how far each may travel before the list is made anew.
struct BroadPhase::Bounds {
  std::vector<BoundingSphere> sphere;  // per shape, not grown
  std::vector<Box3> box;               // per shape
  std::vector<Box3> tree;              // per body that is a root
  std::vector<int> root;               // per shape
  std::vector<int> next;               // per shape: the next one that is of another tree
};

BroadPhase::Bounds BroadPhase::bounds(const Model& m, const Poses& p) const {
  const int n = (int)world_.shapes.size();
  Bounds b{std::vector<BoundingSphere>(n), std::vector<Box3>(n), std::vector<Box3>(m.nbody),
           std::vector<int>(n), std::vector<int>(n, n)};
  for (int i = 0; i < n; i++) b.root[i] = m.root[world_.shapes[i].body];
  for (int i = n - 2; i >= 0; i--) b.next[i] = b.root[i] == b.root[i + 1] ? b.next[i + 1] : i + 1;
  for (int i = 0; i < n; i++) {
    b.sphere[i] = p.bounding_sphere(world_.shapes[i]);
    b.box[i].add(b.sphere[i].center);
    b.box[i].grow(b.sphere[i].radius + range_[i]);
    Box3& t = b.tree[b.root[i]];
    t.add(b.box[i].lo), t.add(b.box[i].hi);
  }
  return b;
}

void BroadPhase::update(const Model& m, const Poses& p, const std::vector<double>& reach,
                        const std::vector<InitialOverlap>& overlaps) {
  const int n = (int)world_.shapes.size();
  bool good = listed_once_;
  for (int i = 0; i < n && good; i++) good = travelled_[i] - listed_[i] + reach[i] <= range_[i];
  if (good) return;
  listed_once_ = true;
  listed_ = travelled_;
  for (int i = 0; i < n; i++) range_[i] = 2 * reach[i] + tune::kListMargin;
  const Bounds b = bounds(m, p);
  old_.clear();
  old_.swap(pairs_);
  next_old_ = 0;
  for (int i = 0; i < n; i++) {
    list_statics(m, b, i, overlaps);
    list_shapes(m, b, i);
  }
}

void BroadPhase::list_statics(const Model& m, const Bounds& b, int i,
                              const std::vector<InitialOverlap>& overlaps) {
  const CollisionShape& M = world_.shapes[i];
  for (int j = 0; j < (int)world_.statics.size(); j++) {
    const Static& S = world_.statics[j];
    if (is_overlapping(overlaps, i, j, -1)) {
      // Listed wherever it is.
    } else if (S.kind == Static::Kind::HalfSpace) {
      if (dot(S.n, b.sphere[i].center) - b.sphere[i].radius - S.offset > range_[i]) continue;
    } else {
      const Box3& other = S.kind == Static::Kind::Hull ? S.posed.box() : S.tree->box();
      if (!b.tree[m.root[M.body]].meets(other) || !b.box[i].meets(other)) continue;
    }
    if (!world_.pairing(M.name, S.name).ignore) add(i, j, -1, false);
  }
}

void BroadPhase::list_shapes(const Model& m, const Bounds& b, int i) {
  const int n = (int)world_.shapes.size();
  for (int j = i + 1, end; j < n; j = end) {
    end = b.next[j];
    const bool own = b.root[i] == b.root[j];
    if (own ? !world_.self_contact() : !b.box[i].meets(b.tree[b.root[j]])) continue;
    for (; j < end; j++)
      if (b.box[i].meets(b.box[j]) && world_.may_touch(m, i, j)) add(i, -1, j, own);
  }
}

namespace {

// The order of the pairs of one shape.
int other_of(int fixed, int other) { return fixed >= 0 ? fixed : (1 << 30) + other; }

}  // namespace

BroadPhasePair& BroadPhase::pair_of(const ContactCandidate& c) {
  const int other = other_of(c.other_static, c.other_shape);
  const auto before = [&](const BroadPhasePair& e, int) {
    return e.shape < c.shape ||
           (e.shape == c.shape && other_of(e.other_static, e.other_shape) < other);
  };
  return *std::lower_bound(pairs_.begin(), pairs_.end(), 0, before);
}

// Appends a pair: the one of the list before, if it was there. Both lists are in the same order.
void BroadPhase::add(int shape, int other_static, int other_shape, bool own) {
  const int mine = other_of(other_static, other_shape);
  auto its = [&]() { return other_of(old_[next_old_].other_static, old_[next_old_].other_shape); };
  while (next_old_ < old_.size() &&
         (old_[next_old_].shape < shape || (old_[next_old_].shape == shape && its() < mine)))
    next_old_++;
  if (next_old_ < old_.size() && old_[next_old_].shape == shape && its() == mine) {
    pairs_.push_back(std::move(old_[next_old_++]));
    return;
  }
  BroadPhasePair e;
  e.shape = shape;
  e.other_static = other_static;
  e.other_shape = other_shape;
  e.own = own;
  pairs_.push_back(std::move(e));
}

bool BroadPhase::covers_people(double range) const {
  const std::vector<CollisionShape>& shapes = world_.shapes;
  bool listed = listed_once_;
  for (size_t i = 0; i < shapes.size() && listed; i++)
    listed = shapes[i].person < 0 || travelled_[i] - listed_[i] + range <= range_[i];
  return listed;
}

bool BroadPhase::behind_planes(const BroadPhasePair& e, const PosedShape& a, double r) const {
  if (!planes_reach(e, r)) return false;
  for (const Plane& p : e.planes)
    if (p.overlaps || a.lowest(p.n) - p.offset <= r + tune::kRounding) return false;
  return true;
}

bool BroadPhase::spheres_apart(Poses& p, BroadPhasePair& e, double r) const {
  const BoundingSphere &a = p.cached_bounding_sphere(world_.shapes, e.shape),
                       &b = p.cached_bounding_sphere(world_.shapes, e.other_shape);
  const double dist = norm(a.center - b.center) - a.radius - b.radius;
  if (dist <= r) return false;
  measured(e, dist);
  return true;
}

void BroadPhase::measure_static(Poses& p, BroadPhasePair& e, double r, size_t* tests) const {
  const PosedShape& a = world_.place(p, e.shape);
  const Static& S = world_.statics[e.other_static];
  e.travelled = travelled(e);
  e.planes_reach = r;
  if (S.kind == Static::Kind::HalfSpace) {
    e.dist = a.lowest(S.n) - S.offset;
    e.planes = {{S.n, S.offset, e.dist, -1, false}};
  } else if (S.kind == Static::Kind::Hull) {
    Separation s = separate(a, S.posed, r, true, e.axis, &e.hint);
    e.axis = s.n;
    e.dist = s.dist;
    e.planes.clear();
    if (norm2(s.n) > 0) e.planes.push_back({s.n, S.posed.highest(s.n), s.dist, -1, s.dist < 0});
  } else {
    e.planes_reach = S.tree->planes(a, r, e.planes, {}, tests);
    e.dist = r;
    for (const Plane& q : e.planes) e.dist = std::min(e.dist, q.dist);
    // The mesh is far: a larger lower bound of its distance saves measurements later.
    if (e.planes.empty()) e.dist = std::max(r, S.tree->distance(a, r + tune::kFartherLook));
  }
}

void BroadPhase::save_travel(std::vector<double>& out) const {
  out.push_back(listed_once_ ? 1 : 0);
  for (const auto* v : {&travelled_, &listed_, &range_})
    out.insert(out.end(), v->begin(), v->end());
  if (world_.self_contact()) out.insert(out.end(), inner_.begin(), inner_.end());
}

const double* BroadPhase::load_travel(const double* in) {
  const size_t n = world_.shapes.size();
  listed_once_ = *in++ != 0;
  for (auto* v : {&travelled_, &listed_, &range_}) {
    v->assign(in, in + n);
    in += n;
  }
  if (!world_.self_contact()) return in;
  inner_.assign(in, in + n);
  return in + n;
}

void BroadPhase::save_pairs(std::vector<double>& out) const {
  out.push_back((double)pairs_.size());
  for (const BroadPhasePair& e : pairs_) {
    out.insert(out.end(), {(double)e.shape, (double)e.other_static, (double)e.other_shape, e.dist,
                           e.travelled, e.planes_reach, e.axis.x, e.axis.y, e.axis.z, e.room,
                           e.room_at, (double)e.planes.size()});
    for (Vec3 n : e.axes.n) out.insert(out.end(), {n.x, n.y, n.z});
    out.push_back(e.axes.next);
    out.push_back(e.hint.n);
    for (int k = 0; k < 3; k++) out.insert(out.end(), {(double)e.hint.a[k], (double)e.hint.b[k]});
    for (const Plane& q : e.planes)
      out.insert(out.end(), {q.n.x, q.n.y, q.n.z, q.offset, q.dist, (double)q.triangle,
                             q.overlaps ? 1.0 : 0.0});
  }
}

const double* BroadPhase::load_pairs(const double* in) {
  pairs_.clear();
  for (int n = (int)*in++; n > 0; n--) {
    BroadPhasePair e;
    e.shape = (int)in[0], e.other_static = (int)in[1], e.other_shape = (int)in[2];
    e.dist = in[3], e.travelled = in[4], e.planes_reach = in[5];
    e.axis = load3(in + 6);
    e.own = e.other_shape >= 0 && world_.may_touch_itself(e.shape, e.other_shape);
    e.room = in[9], e.room_at = in[10];
    int planes = (int)in[11];
    in += 12;
    for (Vec3& n : e.axes.n) n = load3(in), in += 3;
    e.axes.next = (int)*in++;
    e.hint.n = (int)*in++;
    for (int k = 0; k < 3; k++) e.hint.a[k] = (int)*in++, e.hint.b[k] = (int)*in++;
    for (; planes > 0; planes--, in += 7)
      e.planes.push_back({load3(in), in[3], in[4], (int)in[5], in[6] != 0});
    pairs_.push_back(std::move(e));
  }
  return in;
}

}  // namespace hp
