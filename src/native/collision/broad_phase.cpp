// Who is near whom: what need not be looked at in a substep, or in a whole frame.
#include <cmath>

#include "collision/narrow_phase.h"

namespace hp {

namespace {

constexpr double kMargin = 0.1;  // pairs are listed this much farther than asked [m]
constexpr double kFarther = 1;  // where nothing is near it is asked how far this far on [m]
// Plane tests decide up to this; what is nearer is looked at properly [m].
constexpr double kRounding = 1e-9;

}  // namespace

void World::forget() {
  broad_pairs_.clear();
  has_list_ = false;
  odometer_.assign(shapes.size(), 0);
  listed_.assign(shapes.size(), 0);
  range_.assign(shapes.size(), 0);
  inner_.assign(shapes.size(), 0);
}

void World::travel(const std::vector<double>& way, const std::vector<double>& inner) {
  for (size_t i = 0; i < shapes.size(); i++)
    if (active[shapes[i].body]) odometer_[i] += way[i];
  for (size_t i = 0; i < inner.size(); i++)
    if (active[shapes[i].body]) inner_[i] += inner[i];
}

void World::list(const Model& m, const Poses& p, const std::vector<double>& way) {
  const int n = (int)shapes.size();
  bool good = has_list_;
  for (int i = 0; i < n && good; i++) good = odometer_[i] - listed_[i] + way[i] <= range_[i];
  if (good) return;
  has_list_ = true;
  listed_ = odometer_;
  std::vector<Poses::Ball> ball(n);
  std::vector<Box3> box(n);
  std::vector<Box3> tree(m.nbody);
  for (int i = 0; i < n; i++) {
    range_[i] = 2 * way[i] + kMargin;
    ball[i] = p.ball(shapes[i]);
    box[i].add(ball[i].center);
    box[i].grow(ball[i].radius + range_[i]);
    Box3& t = tree[m.root[shapes[i].body]];
    t.add(box[i].lo), t.add(box[i].hi);
  }
  std::vector<BroadPhasePair> old;
  old.swap(broad_pairs_);
  size_t next = 0;
  auto order = [](const BroadPhasePair& e) {
    return e.other_static >= 0 ? e.other_static : (1 << 30) + e.other_shape;
  };
  auto add = [&](BroadPhasePair&& e) {
    while (next < old.size() && (old[next].shape < e.shape ||
                                 (old[next].shape == e.shape && order(old[next]) < order(e))))
      next++;
    if (next < old.size() && old[next].shape == e.shape && order(old[next]) == order(e))
      broad_pairs_.push_back(std::move(old[next++]));
    else
      broad_pairs_.push_back(std::move(e));
  };
  for (int i = 0; i < n; i++) {
    const CollisionShape& M = shapes[i];
    for (int j = 0; j < (int)statics.size(); j++) {
      const Static& S = statics[j];
      if (is_inside(i, j, -1)) {
        // Listed wherever it is.
      } else if (S.kind == Static::Kind::HalfSpace) {
        if (dot(S.n, ball[i].center) - ball[i].radius - S.offset > range_[i]) continue;
      } else {
        const Box3& other = S.kind == Static::Kind::Hull ? S.placed.box : S.tree->box();
        if (!tree[m.root[M.body]].meets(other) || !box[i].meets(other)) continue;
      }
      if (pairing(M.name, S.name).ignore) continue;
      BroadPhasePair e;
      e.shape = i;
      e.other_static = j;
      add(std::move(e));
    }
    for (int j = i + 1; j < n; j++) {
      const bool own = m.root[M.body] == m.root[shapes[j].body];
      if (own && self_.empty()) continue;
      if (!box[i].meets(box[j]) || !may_touch(m, i, j)) continue;
      BroadPhasePair e;
      e.shape = i;
      e.other_shape = j;
      e.own = own;
      add(std::move(e));
    }
  }
}

// Does what is known of the other keep it farther than r? The planes hold where they were asked for.
bool World::behind_planes(const BroadPhasePair& e, const PosedShape& a, double r) const {
  if (e.planes.empty() || way_of(e) - e.way + r > e.reach) return false;
  for (const Plane& p : e.planes)
    if (p.overlaps || a.lowest(p.n) - p.offset <= r + kRounding) return false;
  return true;
}

// Looks at a pair of a shape and a static properly, up to a distance of r.
void World::look(Poses& p, BroadPhasePair& e, double r) {
  const PosedShape& a = place(p, e.shape);
  const Static& S = statics[e.other_static];
  e.way = way_of(e);
  e.reach = r;
  if (S.kind == Static::Kind::HalfSpace) {
    e.dist = a.lowest(S.n) - S.offset;
    e.planes = {{S.n, S.offset, e.dist, -1, false}};
  } else if (S.kind == Static::Kind::Hull) {
    Separation s = separate(a, S.placed, r, true, e.axis, &e.hint);
    e.axis = s.n;
    e.dist = s.dist;
    e.planes.clear();
    if (norm2(s.n) > 0)
      e.planes.push_back({s.n, S.placed.highest(s.n), s.dist, -1, s.dist < 0});
  } else {
    if (!S.tree->planes(a, r, e.planes)) e.reach = 0;
    e.dist = r;
    for (const Plane& q : e.planes) e.dist = std::min(e.dist, q.dist);
    // Nothing near: how much farther there is nothing saves many looks.
    if (e.planes.empty()) e.dist = std::max(r, S.tree->distance(a, r + kFarther));
  }
}

void World::find_busy(const Model& m, Poses& start, Poses& end, const Sweep& sweep,
                      std::vector<char>& busy) {
  for (const Inside& in : inside_) {
    busy[m.root[shapes[in.shape].body]] = 1;
    if (in.other_shape >= 0) busy[m.root[shapes[in.other_shape].body]] = 1;
  }
  for (BroadPhasePair& e : broad_pairs_) {
    const CollisionShape& M = shapes[e.shape];
    const int mine = m.root[M.body];
    const double clear = settings.clearance + kRounding;
    if (e.other_shape >= 0) {
      const int its = m.root[shapes[e.other_shape].body];
      if (busy[mine] && busy[its]) continue;
      if (e.own) {
        busy[mine] = meets_itself(m, start, end, sweep, e);
        continue;
      }
      double r = sweep.way[e.shape] + sweep.way[e.other_shape] + clear;
      if (far(e, r)) continue;
      e.dist = separate(place(start, e.shape), place(start, e.other_shape), r + kMargin).dist;
      e.way = way_of(e);
      if (e.dist <= r) busy[mine] = busy[its] = 1;
      continue;
    }
    if (busy[mine]) continue;
    double r = sweep.way[e.shape] + clear;
    if (far(e, r)) continue;
    // On the outer side at both ends and nowhere farther from the line between: clear.
    auto passes = [&]() {
      if (e.planes.empty() || way_of(e) - e.way + r > e.reach) return false;
      double bulge = clear + sweep.bulge[e.shape];
      for (const Plane& p : e.planes)
        if (p.overlaps || place(start, e.shape).lowest(p.n) - p.offset <= bulge ||
            place(end, e.shape).lowest(p.n) - p.offset <= bulge)
          return false;
      return true;
    };
    if (passes()) continue;
    look(start, e, r + kMargin);
    if (e.dist > r || passes()) continue;
    busy[mine] = 1;
  }
}

// Caches are saved too: what is found first among equals depends on them, to rounding.
void World::save_near(std::vector<double>& out) const {
  out.push_back(has_list_ ? 1 : 0);
  for (const auto* v : {&odometer_, &listed_, &range_}) out.insert(out.end(), v->begin(), v->end());
  if (self_contact()) {
    out.insert(out.end(), inner_.begin(), inner_.end());
    out.insert(out.end(), {(double)waited_, depth_});
  }
  out.push_back((double)broad_pairs_.size());
  for (const BroadPhasePair& e : broad_pairs_) {
    out.insert(out.end(), {(double)e.shape, (double)e.other_static, (double)e.other_shape, e.dist,
                           e.way, e.reach, e.axis.x, e.axis.y, e.axis.z,
                           (double)e.planes.size()});
    out.push_back(e.hint.n);
    for (int k = 0; k < 3; k++) out.insert(out.end(), {(double)e.hint.a[k], (double)e.hint.b[k]});
    for (const Plane& q : e.planes)
      out.insert(out.end(), {q.n.x, q.n.y, q.n.z, q.offset, q.dist, (double)q.triangle,
                             q.overlaps ? 1.0 : 0.0});
  }
}

const double* World::load_near(const double* in) {
  has_list_ = *in++ != 0;
  for (auto* v : {&odometer_, &listed_, &range_}) {
    v->assign(in, in + shapes.size());
    in += shapes.size();
  }
  if (self_contact()) {
    inner_.assign(in, in + shapes.size());
    in += shapes.size();
    waited_ = (int)*in++;
    depth_ = *in++;
  }
  broad_pairs_.clear();
  for (int n = (int)*in++; n > 0; n--) {
    BroadPhasePair e;
    e.shape = (int)in[0], e.other_static = (int)in[1], e.other_shape = (int)in[2];
    e.dist = in[3], e.way = in[4], e.reach = in[5];
    e.axis = load3(in + 6);
    e.own = self_contact() && e.other_shape >= 0 && self_[e.shape * shapes.size() + e.other_shape];
    int planes = (int)in[9];
    in += 10;
    e.hint.n = (int)*in++;
    for (int k = 0; k < 3; k++) e.hint.a[k] = (int)*in++, e.hint.b[k] = (int)*in++;
    for (; planes > 0; planes--, in += 7)
      e.planes.push_back({load3(in), in[3], in[4], (int)in[5], in[6] != 0});
    broad_pairs_.push_back(std::move(e));
  }
  return in;
}

}  // namespace hp
