#include "geometry/bvh.h"

#include <algorithm>
#include <cmath>

#include "geometry/gjk.h"
#include "geometry/tree_queue.h"
#include "geometry/triangle_points.h"
#include "geometry/triangle_touch.h"
#include "tuning.h"

namespace hp {

namespace tune = tuning::geometry;

namespace {

double gap2(const Box3& a, const Box3& b) {
  double s = 0;
  for (int k = 0; k < 3; k++) {
    double g = std::max(0.0, std::max(a.lo[k] - b.hi[k], b.lo[k] - a.hi[k]));
    s += g * g;
  }
  return s;
}

// Does a triangle lie behind a plane, up to a tolerance?
bool behind(const Plane& p, const Vec3 v[3], double tolerance) {
  double o = p.offset + tolerance;
  return dot(p.n, v[0]) <= o && dot(p.n, v[1]) <= o && dot(p.n, v[2]) <= o;
}

// The plane of the nearest points of a shape and a triangle; dist > reach where they are farther.
Plane plane_to(const PosedShape& a, const Vec3 v[3], int t, double reach, Vec3 guess = {}) {
  const TrianglePoints triangle(v);
  Vec3 pa, pb;
  if (norm2(guess) == 0) guess = a.center - nearest_on(v, a.center);
  double r = a.hull->radius, d = gjk(a.support(), triangle.support(), guess, pa, pb, reach + r);
  if (d > reach + r) {
    Vec3 n = pa - pb;
    return {n, highest(v, n), d - r, t, false};
  }
  if (d > tune::kProvedApart) {
    Vec3 n = (1 / d) * (pa - pb);
    double offset = highest(v, n);
    // A line of rounding's length may point anywhere: it counts only if it separates.
    if (d > tune::kTouching || a.lowest(n) - offset > d - r - tune::kSeparates)
      return {n, offset, d - r, t, d - r < -tune::kMeshTouch};
  }
  // They touch or overlap: the shorter way out along the triangle's own normal.
  Vec3 n = cross(v[1] - v[0], v[2] - v[0]);
  double length = norm(n);
  if (length < tune::kNoTriangle) return {{}, 0, 0, t, true};
  n = (1 / length) * n;
  double up = a.lowest(n) - dot(n, v[0]), down = a.lowest(-n) + dot(n, v[0]);
  Vec3 side = up >= down ? n : -n;
  double depth = std::max(up, down);
  return {side, dot(side, v[0]), depth, t, depth < -tune::kMeshTouch};
}

// Where that says they overlap: do they touch, along a direction of their own?
void look_for_touch(const PosedShape& a, const Vec3 v[3], Plane& p) {
  const Vec3 touch = touch_direction(a, v);
  if (norm2(touch) == 0) return;
  const double dist = a.lowest(touch) - highest(v, touch);
  if (dist > -tune::kMeshTouch) p = {touch, highest(v, touch), dist, p.triangle, false};
}

double square(const Plane& p) { return p.dist > 0 ? p.dist * p.dist : 0; }

}  // namespace

void TriangleTree::triangle(int t, Vec3 v[3]) const {
  for (int k = 0; k < 3; k++) v[k] = corner_[3 * (size_t)t + k];
}

// One call of planes(). Triangles are settled in the order of their distance. One whose plane has
// been computed before its turn ("known": its distance is larger than its box said) waits in the
// queue; whatever lies behind that plane and is not nearer waits with it, because it is culled if
// the plane is found and is asked again if not.
struct TriangleTree::PlaneSearch {
  struct Known {
    Plane plane;
    int first = -1;  // of what waits with it, in `waiting`
  };
  struct Waiting {
    TreeEntry entry;
    int next;
  };
  // Kept from call to call: nothing is allocated once warm.
  struct Scratch {
    TreeQueue queue;
    std::vector<Known> known;
    std::vector<Waiting> waiting;
    std::vector<Plane> out_of_reach;  // nothing behind these is within reach
  };

  const TriangleTree& tree;
  const PosedShape& a;
  const double reach;
  const std::vector<int>& without;
  std::vector<Plane>& out;
  Scratch& s;
  size_t tests = 0;            // of boxes and triangles against planes
  size_t tests_of_shapes = 0;  // what measuring triangles costs, in such tests

  double run();  // the reach that the planes hold for

 private:
  bool too_many(const TreeEntry& next) const;
  bool left_out(int t) const { return std::binary_search(without.begin(), without.end(), t); }
  // Is everything that `is_behind` tests culled by a plane that is found or out of reach, or put to
  // wait?
  template <typename Behind>
  bool settled(const TreeEntry& e, Behind is_behind) {
    tests += out.size() + s.out_of_reach.size() + s.known.size();
    for (const Plane& p : out)
      if (!p.overlaps && is_behind(p)) return true;
    for (const Plane& p : s.out_of_reach)
      if (is_behind(p)) return true;
    for (Known& k : s.known) {
      if (k.plane.overlaps || square(k.plane) <= e.d2 || !is_behind(k.plane)) continue;
      s.waiting.push_back({e, k.first});
      k.first = (int)s.waiting.size() - 1;
      return true;
    }
    return false;
  }
  bool node_settled(const TreeEntry& e) {
    const Box3& box = tree.nodes_[e.id].box;
    return settled(e,
                   [&](const Plane& p) { return box.highest(p.n) <= p.offset + tune::kBoxBehind; });
  }
  bool triangle_settled(const TreeEntry& e, const Vec3 v[3]) {
    return settled(e, [&](const Plane& p) { return behind(p, v, tune::kTriangleBehind); });
  }
  Plane measure(int t, const Vec3 v[3], Vec3 guess);
  void measure_old();
  void open(const TreeEntry& e);
  void visit(const TreeEntry& e);
  void take_turn(const TreeEntry& e, Known& known, const Vec3 v[3]);
};

Plane TriangleTree::PlaneSearch::measure(int t, const Vec3 v[3], Vec3 guess) {
  Plane p = plane_to(a, v, t, reach, guess);
  tests_of_shapes += tune::kMeasureTests;
  if (!p.overlaps) return p;
  tests_of_shapes += tune::kTouchTests;
  look_for_touch(a, v, p);
  return p;
}

void TriangleTree::PlaneSearch::measure_old() {
  for (const Plane& old : out) {
    if (left_out(old.triangle)) continue;
    Vec3 v[3];
    tree.triangle(old.triangle, v);
    Plane p = measure(old.triangle, v, old.n);
    if (p.dist > reach) {
      s.out_of_reach.push_back(p);
    } else {
      s.known.push_back({p, -1});
      s.queue.push(square(p), -1 - old.triangle);
    }
  }
  out.clear();
}

// A node's children, or its triangles.
void TriangleTree::PlaneSearch::open(const TreeEntry& e) {
  if (node_settled(e)) return;
  const Node& node = tree.nodes_[e.id];
  if (node.left >= 0) {
    for (int child : {node.left, node.right}) {
      TreeEntry c{std::max(gap2(tree.nodes_[child].box, a.box()), e.d2), child};
      if (c.d2 <= reach * reach && !node_settled(c)) s.queue.push(c.d2, c.id);
    }
    return;
  }
  for (int i = node.first; i < node.first + node.count; i++) {
    Vec3 v[3];
    tree.triangle(i, v);
    Box3 box;
    for (Vec3 p : v) box.add(p);
    TreeEntry c{std::max(gap2(box, a.box()), e.d2), -1 - i};
    if (c.d2 <= reach * reach && !left_out(i) && !triangle_settled(c, v)) s.queue.push(c.d2, c.id);
  }
}

// The turn of a triangle whose plane is known.
void TriangleTree::PlaneSearch::take_turn(const TreeEntry& e, Known& known, const Vec3 v[3]) {
  if (e.d2 < square(known.plane) * (1 - 1e-12)) return;  // its turn comes
  bool culled = false;
  for (const Plane& p : out) culled |= !p.overlaps && behind(p, v, tune::kTriangleBehind);
  if (!culled) {
    out.push_back(known.plane);
    known.first = -1;  // what waits is culled with it
    return;
  }
  // Culled itself, it culls nothing: what waits is asked again.
  int w = known.first;
  known.plane.dist = 0;
  for (; w >= 0; w = s.waiting[w].next)
    s.queue.push(std::max(s.waiting[w].entry.d2, e.d2), s.waiting[w].entry.id);
  known.first = -1;
}

void TriangleTree::PlaneSearch::visit(const TreeEntry& e) {
  const int t = -1 - e.id;
  Vec3 v[3];
  tree.triangle(t, v);
  auto it = std::find_if(s.known.begin(), s.known.end(),
                         [&](const Known& k) { return k.plane.triangle == t; });
  if (it != s.known.end()) return take_turn(e, *it, v);
  if (triangle_settled(e, v)) return;
  Plane p = measure(t, v, {});
  if (p.dist > reach) {
    if (s.out_of_reach.size() < tune::kMostCullers) s.out_of_reach.push_back(p);
  } else if (!s.queue.heap.empty() && square(p) > s.queue.heap.front().d2) {
    s.known.push_back({p, -1});
    s.queue.push(square(p), e.id);
  } else {
    out.push_back(p);
  }
}

// Are there planes enough to move some way with, everything nearer than `next` being settled?
bool TriangleTree::PlaneSearch::too_many(const TreeEntry& next) const {
  const size_t n = out.size();
  return n >= tune::kMostPlanes || tests >= tune::kMostTests ||
         ((n >= tune::kManyPlanes || tests >= tune::kManyTests) &&
          next.d2 > tune::kEnoughReach * tune::kEnoughReach);
}

double TriangleTree::PlaneSearch::run() {
  s.queue.heap.clear();
  s.known.clear();
  s.waiting.clear();
  s.out_of_reach.clear();
  measure_old();
  double start = gap2(tree.nodes_[0].box, a.box());
  if (start <= reach * reach) s.queue.push(start, 0);
  while (!s.queue.heap.empty()) {
    const TreeEntry e = s.queue.pop();
    if (too_many(e)) return std::min(reach, std::sqrt(e.d2));
    if (e.id >= 0)
      open(e);
    else
      visit(e);
  }
  return reach;
}

double TriangleTree::planes(const PosedShape& a, double reach, std::vector<Plane>& out,
                            const std::vector<int>& without, size_t* tests) const {
  static thread_local PlaneSearch::Scratch scratch;
  PlaneSearch search{*this, a, reach, without, out, scratch};
  const double holds = search.run();
  if (tests) *tests += search.tests + search.tests_of_shapes;
  return holds;
}

// One call of distance(): triangles behind a plane that was measured are no nearer than its
// triangle, and so no nearer than the best.
struct TriangleTree::DistanceSearch {
  struct Scratch {
    TreeQueue queue;
    std::vector<Plane> measured;
  };
  const TriangleTree& tree;
  const PosedShape& a;
  double best;
  const double enough;  // nothing is sought that is nearer than this
  const bool touches;   // are overlaps looked at for touches? That costs as much as five triangles
  Scratch& s;
  Plane nearest{};   // where `best` was found
  size_t tests = 0;  // of boxes and triangles against planes, and what else costs as much

  void measure(int t, const Vec3 v[3]) {
    tests += tune::kMeasureTests;
    Plane p = plane_to(a, v, t, std::max(best, 0.0));
    if (touches && p.overlaps && p.dist < best) {
      tests += tune::kTouchTests;
      look_for_touch(a, v, p);
    }
    if (p.dist < best) best = p.dist, nearest = p;
    if (!p.overlaps && norm2(p.n) > 0 && s.measured.size() < tune::kMostCullers)
      s.measured.push_back(p);
  }
  void push(int id) {
    tests += tune::kBoxTests + s.measured.size();
    const Box3& box = tree.nodes_[id].box;
    double d2 = gap2(box, a.box());
    if (best > 0 && d2 > best * best) return;
    for (const Plane& p : s.measured)
      if (box.highest(p.n) <= p.offset) return;
    s.queue.push(d2, id);
  }
  void measure_leaf(const Node& node) {
    for (int i = node.first; i < node.first + node.count && best >= enough; i++) {
      Vec3 v[3];
      tree.triangle(i, v);
      bool culled = false;
      tests += s.measured.size();
      for (const Plane& p : s.measured) culled |= behind(p, v, 0);
      if (!culled) measure(i, v);
    }
  }
  double run(const std::vector<Plane>& near) {
    s.queue.heap.clear();
    s.measured.clear();
    for (const Plane& p : near) {
      Vec3 v[3];
      tree.triangle(p.triangle, v);
      measure(p.triangle, v);
    }
    push(0);
    while (!s.queue.heap.empty() && best >= enough) {
      TreeEntry e = s.queue.pop();
      if (e.d2 > 0 && (best <= 0 || e.d2 > best * best)) break;
      const Node& node = tree.nodes_[e.id];
      if (node.left < 0) {
        measure_leaf(node);
        continue;
      }
      push(node.left);
      push(node.right);
    }
    return best;
  }
};

double TriangleTree::distance(const PosedShape& a, double range,
                              const std::vector<Plane>& near) const {
  static thread_local DistanceSearch::Scratch scratch;
  return DistanceSearch{*this, a, range, -1e300, true, scratch}.run(near);
}

bool TriangleTree::nearer(const PosedShape& a, double range, size_t& tests) const {
  static thread_local DistanceSearch::Scratch scratch;
  DistanceSearch search{*this, a, range, range, false, scratch};
  const bool found = search.run({}) < range;
  tests += search.tests;
  return found;
}

bool TriangleTree::nearest(const PosedShape& a, double range, Plane& out, size_t& tests) const {
  static thread_local DistanceSearch::Scratch scratch;
  DistanceSearch search{*this, a, range, -1e300, false, scratch};
  const bool found = search.run({}) < range;
  tests += search.tests;
  if (found) out = search.nearest;
  return found;
}

double TriangleTree::winding(Vec3 p) const {
  double sum = 0;
  for (size_t t = 0; t < corner_.size(); t += 3) {
    const Vec3 a = corner_[t] - p, b = corner_[t + 1] - p, c = corner_[t + 2] - p;
    const double x = norm(a), y = norm(b), z = norm(c);
    sum += elementary::atan2(dot(a, cross(b, c)),
                             x * y * z + dot(a, b) * z + dot(b, c) * x + dot(c, a) * y);
  }
  return sum / (2 * M_PI);
}

}  // namespace hp
