// A tree of bounding volumes over a triangle soup, for queries by points: the exact closest
// triangle, signed crossings of a vertical ray, and the generalised winding number (Jacobson et al.
// 2013) with a proven error. (geometry/bvh.h is the tree for queries by convex shapes.)
//
// Built by median splits. Far triangles enter the winding number as a cluster (triangle_cluster.h),
// near ones by their solid angles; because every cluster carries a strict bound of its error, a
// point is refined until the error cannot change the answer. Where many points are compared with
// one threshold, whole balls of them are decided at once. Depth is at most log2(triangles) + 1.
#pragma once

#include <algorithm>
#include <cmath>
#include <limits>
#include <stdexcept>
#include <vector>

#include "geometry/triangle_cluster.h"
#include "tuning.h"

namespace triangles {

namespace tune = hp::tuning::geometry;

constexpr int kStack = 128;         // median splits: depth is at most log2(triangles) + 1
constexpr double kUnknown = 100.0;  // an error that exceeds any winding number

struct Node {
  int left;          // index of the left child (the right one follows it), -1 in a leaf
  int first, count;  // its triangles
};

class Tree {
 public:
  // `winding`: also keep what `winding` and `exceeds` need.
  Tree(const double* v, size_t n_vertices, const int* f, size_t n_faces, bool winding)
      : winding_(winding) {
    triangles_.reserve(n_faces);
    for (size_t i = 0; i < n_faces; ++i) {
      Vec corner[3];
      for (int k = 0; k < 3; ++k) {
        const int j = f[3 * i + k];
        if (j < 0 || static_cast<size_t>(j) >= n_vertices)
          throw std::invalid_argument("a face names a vertex that does not exist");
        corner[k] = {v[3 * j], v[3 * j + 1], v[3 * j + 2]};
      }
      const Vec e = corner[1] - corner[0], g = corner[2] - corner[0], k = corner[2] - corner[1];
      const Vec normal = cross(e, g);
      const double longest = std::max({dot(e, e), dot(g, g), dot(k, k)});
      const bool sliver = !(dot(normal, normal) > 1e-20 * longest * longest);
      triangles_.push_back({corner[0], corner[1], corner[2], static_cast<int>(i), sliver});
    }
    if (triangles_.empty()) throw std::invalid_argument("a mesh needs at least one triangle");
    nodes_.resize(1);
    boxes_.resize(1);
    slabs_.resize(1);
    if (winding_) clusters_.resize(1);
    build(0, 0, static_cast<int>(triangles_.size()));
  }

  // Winding number at q. A cluster is opened unless its remainder is at most `share`; `error`
  // receives the sum of all remainders: a strict bound of what the answer is off by.
  double winding(Vec q, double share, double& error) const {
    int stack[kStack];
    int top = 0;
    stack[top++] = 0;
    double near = 0.0, far = 0.0, rest = 0.0;
    while (top) {
      const int index = stack[--top];
      const Cluster& c = clusters_[index];
      const Node& node = nodes_[index];
      const Vec r = c.centre - q;
      const double d2 = slab_distance2(slabs_[index], q), d4 = d2 * d2;
      if (d2 > 0.0 && c.remainder <= share * d4) {
        const double r2 = dot(r, r), length = std::sqrt(r2);
        const double inv2 = 1.0 / r2, inv3 = inv2 / length;
        far += far_field(c, r, inv2, inv3);
        rest += c.remainder / d4;
      } else if (node.left < 0) {
        for (int i = node.first; i < node.first + node.count; ++i) {
          const Triangle& t = triangles_[i];
          near += half_solid_angle(t.a - q, t.b - q, t.c - q);
        }
      } else {
        stack[top++] = node.left;
        stack[top++] = node.left + 1;
      }
    }
    error = rest;
    return far + 2.0 * near / kFourPi;
  }

  // As above, refined until the proven error is at most `tolerance` (0: the full sum).
  double winding_within(Vec q, double tolerance) const {
    double error;
    for (double share = 0.1 * tolerance; share > 1e-15; share *= 0.1) {
      const double w = winding(q, share, error);
      if (error <= tolerance) return w;
    }
    return winding(q, -1.0, error);
  }

  // Whether the winding number is over a threshold, as the full sum would say.
  bool exceeds(Vec q, double threshold) const {
    double error;
    for (double share : {2e-2, 1e-3, 1e-5, 1e-8}) {
      const double w = winding(q, share, error);
      if (std::abs(w - threshold) > error + 1e-9) return w > threshold;
    }
    return winding(q, -1.0, error) > threshold;
  }

  // Whether the winding number is over a threshold in all of a ball (or at a point: rho = 0), as
  // the full sum would say: 1 yes, 0 no, -1 not known after so many steps. The cluster that leaves
  // most open is opened first, until what is open cannot change the answer.
  int decide(Vec q, double rho, double threshold, int steps) const {
    Open heap[tune::kMostOpened + 1];
    int size = 0;
    double value = 0.0,
           off = 0.0;  // at the centre, and a bound of the difference anywhere in the ball
    auto less = [](const Open& a, const Open& b) { return a.off < b.off; };
    auto add = [&](int index) {
      const Open open = seen(index, q, rho);
      value += open.value;
      off += open.off;
      if (open.node < 0) return;  // nothing in it can be opened
      heap[size++] = open;
      std::push_heap(heap, heap + size, less);
    };
    add(0);
    for (int k = 0;; ++k) {
      if (std::abs(value - threshold) > off + 1e-9) return value > threshold;
      if (size == 0 || k == steps) return -1;
      std::pop_heap(heap, heap + size, less);
      const Open open = heap[--size];
      value -= open.value;
      off -= open.off;
      add(nodes_[open.node].left);
      add(nodes_[open.node].left + 1);
    }
  }

  // `exceeds` of the n points order[i] with one threshold: tell(order[i], answer). Where one answer
  // holds for a whole ball, its points get it at once. `order` is changed.
  template <typename Point, typename Tell>
  void exceeds_all(const Point& point, int* order, int n, double threshold,
                   const Tell& tell) const {
    if (n <= tune::kFewPoints) {
      for (int i = 0; i < n; ++i) tell(order[i], exceeds(point(order[i]), threshold));
      return;
    }
    const double inf = std::numeric_limits<double>::infinity();
    Vec lo{inf, inf, inf}, hi{-inf, -inf, -inf};
    for (int i = 0; i < n; ++i) {
      const Vec p = point(order[i]);
      lo = {std::min(lo.x, p.x), std::min(lo.y, p.y), std::min(lo.z, p.z)};
      hi = {std::max(hi.x, p.x), std::max(hi.y, p.y), std::max(hi.z, p.z)};
    }
    const Vec extent = hi - lo;
    const int known = decide(0.5 * (lo + hi), 0.5 * norm(extent), threshold,
                             std::min(tune::kMostOpened, tune::kOpenedEach * n));
    if (known >= 0) {
      for (int i = 0; i < n; ++i) tell(order[i], known == 1);
      return;
    }
    const int k =
        extent.x >= extent.y ? (extent.x >= extent.z ? 0 : 2) : (extent.y >= extent.z ? 1 : 2);
    std::sort(order, order + n,
              [&](int a, int b) { return axis(point(a), k) < axis(point(b), k); });
    for (int i = 0; i < tune::kPointParts; ++i) {
      const int first = n * i / tune::kPointParts, end = n * (i + 1) / tune::kPointParts;
      exceeds_all(point, order + first, end - first, threshold, tell);
    }
  }

  // Triangles that the ray from q upward (+z) crosses, counted +1 where they face up and -1
  // where they face down: the winding number, where the triangles are closed. Seen from above
  // every triangle is three directed edges, and an edge counts by comparisons that give its
  // two triangles opposite signs whatever the rounding: nothing leaks through an edge.
  int crossings(Vec q) const {
    int stack[kStack];
    int top = 0, sum = 0;
    stack[top++] = 0;
    while (top) {
      const int node = stack[--top];
      const Box& b = boxes_[node];
      if (q.x < b.lo.x || q.x > b.hi.x || q.y < b.lo.y || q.y > b.hi.y || q.z > b.hi.z) continue;
      const Node& n = nodes_[node];
      if (n.left >= 0) {
        stack[top++] = n.left;
        stack[top++] = n.left + 1;
        continue;
      }
      for (int i = n.first; i < n.first + n.count; ++i) {
        const Triangle& t = triangles_[i];
        const int turn = passes(q, t.a, t.b) + passes(q, t.b, t.c) + passes(q, t.c, t.a);
        if (turn == 0) continue;
        // The sign of the volume over q says on which side of the plane q is.
        const double volume = dot(t.a - q, cross(t.b - q, t.c - q));
        if (turn * volume > 0.0) sum += turn;
      }
    }
    return sum;
  }

  // Closest triangle; of several equally near the one listed first. `guess` (or -1) is a
  // triangle that is likely near: it changes the time taken, not the answer. -1: none is within
  // `limit`, and `distance` is that.
  int closest(Vec p, int guess, Vec& point, double& distance,
              double limit = std::numeric_limits<double>::infinity()) const {
    struct Open {
      double d2;
      int node;
    };
    Open stack[kStack];
    int top = 0, best = -1;
    double best2 = limit * limit;
    auto ask = [&](int i) {
      const Vec q = closest_on_triangle(p, triangles_[i]);
      const double d2 = dot(p - q, p - q);
      if (d2 < best2 || (d2 == best2 && (best < 0 || triangles_[i].face < triangles_[best].face))) {
        best2 = d2;
        best = i;
        point = q;
      }
    };
    if (guess >= 0) ask(guess);
    auto bound = [&](int node) {
      const double d2 = box_distance2(boxes_[node], p);
      return d2 > best2 ? d2 : std::max(d2, slab_distance2(slabs_[node], p));
    };
    stack[top++] = {bound(0), 0};
    while (top) {
      const Open open = stack[--top];
      if (open.d2 > best2) continue;
      const Node& n = nodes_[open.node];
      if (n.left < 0) {
        for (int i = n.first; i < n.first + n.count; ++i) ask(i);
        continue;
      }
      Open l{bound(n.left), n.left}, r{bound(n.left + 1), n.left + 1};
      if (l.d2 < r.d2) std::swap(l, r);
      if (l.d2 <= best2) stack[top++] = l;
      if (r.d2 <= best2) stack[top++] = r;
    }
    distance = std::sqrt(best2);
    return best;
  }

  // The shares of a triangle's corners in a point of it; equal ones where it has no area.
  Vec shares(int triangle, Vec q) const {
    const Triangle& t = triangles_[triangle];
    const Vec normal = cross(t.b - t.a, t.c - t.a);
    const double area2 = dot(normal, normal);
    if (t.sliver || !(area2 > 0.0)) return {1.0 / 3, 1.0 / 3, 1.0 / 3};
    const double b = std::clamp(dot(cross(q - t.a, t.c - t.a), normal) / area2, 0.0, 1.0);
    const double c = std::clamp(dot(cross(t.b - t.a, q - t.a), normal) / area2, 0.0, 1.0 - b);
    return {1.0 - b - c, b, c};
  }

  int face(int triangle) const { return triangles_[triangle].face; }
  bool has_winding() const { return winding_; }

 private:
  // What a node adds to the winding number, a bound of its error, and the node, or -1 where nothing
  // in it can be opened.
  struct Open {
    double off, value;
    int node;
  };

  // A node seen from a ball.
  Open seen(int index, Vec q, double rho) const {
    const Cluster& c = clusters_[index];
    const Node& node = nodes_[index];
    const Vec r = c.centre - q;
    const double length = norm(r), d = std::sqrt(slab_distance2(slabs_[index], q)) - rho;
    if (d > 0.0) {
      const double inv = 1.0 / d, inv3 = inv * inv * inv, inv4 = inv3 * inv;
      const double off =
          c.remainder * inv4 +
          rho * (c.change[0] * inv3 + (c.change[1] + 4.0 * c.remainder * inv) * inv4);
      // Sums would lose small errors beside a very large one: that counts as unknown.
      if (node.left >= 0 ? off < kUnknown : off < 1e-3) {
        const double inv2 = 1.0 / (length * length);
        return {off, far_field(c, r, inv2, inv2 / length), node.left >= 0 ? index : -1};
      }
    }
    if (node.left >= 0) return {kUnknown, 0.0, index};
    if (rho > 0.0 && d <= 0.0) return {kUnknown, 0.0, -1};
    double value = 0.0, area = 0.0;
    for (int i = node.first; i < node.first + node.count; ++i) {
      const Triangle& t = triangles_[i];
      value += 2.0 / kFourPi * half_solid_angle(t.a - q, t.b - q, t.c - q);
      area += norm(cross(t.b - t.a, t.c - t.a));  // twice
    }
    return {rho > 0.0 ? rho * area / (kFourPi * d * d * d) : 0.0, value, -1};
  }

  // +1 (upward) or -1 (downward) where the edge crosses the ray from q along +x, in the xy plane.
  static int passes(Vec q, Vec a, Vec b) {
    const bool up = a.y <= q.y && q.y < b.y, down = b.y <= q.y && q.y < a.y;
    if (!up && !down) return 0;
    if (down) std::swap(a, b);
    const bool right = (b.x - a.x) * (q.y - a.y) - (b.y - a.y) * (q.x - a.x) > 0.0;
    return right ? (up ? 1 : -1) : 0;
  }

  void build(int node, int first, int count) {
    const double inf = std::numeric_limits<double>::infinity();
    Box box{{inf, inf, inf}, {-inf, -inf, -inf}}, middle = box;
    auto grow = [](Box& b, Vec p) {
      b.lo = {std::min(b.lo.x, p.x), std::min(b.lo.y, p.y), std::min(b.lo.z, p.z)};
      b.hi = {std::max(b.hi.x, p.x), std::max(b.hi.y, p.y), std::max(b.hi.z, p.z)};
    };
    for (int i = first; i < first + count; ++i) {
      const Triangle& t = triangles_[i];
      for (Vec p : {t.a, t.b, t.c}) grow(box, p);
      grow(middle, t.a + t.b + t.c);
    }
    boxes_[node] = box;
    slabs_[node] = flat(&triangles_[first], count, box);
    nodes_[node] = {-1, first, count};
    if (winding_) clusters_[node] = describe(&triangles_[first], count, box);
    if (count <= tune::kPointLeaf) return;
    const Vec extent = middle.hi - middle.lo;
    const int k =
        extent.x >= extent.y ? (extent.x >= extent.z ? 0 : 2) : (extent.y >= extent.z ? 1 : 2);
    const int half = count / 2;
    const auto begin = triangles_.begin() + first;
    std::nth_element(begin, begin + half, begin + count, [k](const Triangle& s, const Triangle& t) {
      const double u = axis(s.a, k) + axis(s.b, k) + axis(s.c, k);
      const double v = axis(t.a, k) + axis(t.b, k) + axis(t.c, k);
      return u < v || (u == v && s.face < t.face);
    });
    const int left = static_cast<int>(nodes_.size());
    nodes_[node].left = left;
    nodes_.resize(left + 2);
    boxes_.resize(left + 2);
    slabs_.resize(left + 2);
    if (winding_) clusters_.resize(left + 2);
    build(left, first, half);
    build(left + 1, first + half, count - half);
  }

  std::vector<Triangle> triangles_;  // in the tree's order
  std::vector<Node> nodes_;
  std::vector<Box> boxes_;
  std::vector<Slab> slabs_;
  std::vector<Cluster> clusters_;  // empty unless winding_
  bool winding_;
};

}  // namespace triangles
