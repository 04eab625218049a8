// A tree of bounding volumes over a triangle soup, asked by points: the exact closest triangle,
// signed crossings of a vertical ray, and the winding number with a proven error.
//
// Far triangles enter the winding number as a cluster: the Taylor expansion of its solid angle
// to second order (Barill et al. 2018). Here every cluster also carries a strict bound of what
// the expansion leaves out; a point is refined until that error cannot change the answer.
#pragma once

#include <algorithm>
#include <cmath>
#include <limits>
#include <stdexcept>
#include <vector>

namespace triangles {

constexpr double kFourPi = 12.566370614359172954;
constexpr int kLeaf = 4;       // triangles in a leaf
constexpr int kStack = 128;    // median splits: depth is at most log2(triangles) + 1
constexpr int kSteps = 2048;   // clusters opened at most for one question
constexpr double kUnknown = 100.0;    // off by more than any winding number that is asked for

struct Vec {
  double x, y, z;
};
inline Vec operator+(Vec a, Vec b) { return {a.x + b.x, a.y + b.y, a.z + b.z}; }
inline Vec operator-(Vec a, Vec b) { return {a.x - b.x, a.y - b.y, a.z - b.z}; }
inline Vec operator*(double s, Vec a) { return {s * a.x, s * a.y, s * a.z}; }
inline double dot(Vec a, Vec b) { return a.x * b.x + a.y * b.y + a.z * b.z; }
inline Vec cross(Vec a, Vec b) {
  return {a.y * b.z - a.z * b.y, a.z * b.x - a.x * b.z, a.x * b.y - a.y * b.x};
}
inline double norm(Vec a) { return std::sqrt(dot(a, a)); }

struct Triangle {
  Vec a, b, c;
  int face;        // index in the caller's list
  bool sliver;     // no usable normal: its closest point is sought on its edges
};

// Half the solid angle of a triangle seen from the origin (Van Oosterom and Strackee 1983).
inline double half_solid_angle(Vec a, Vec b, Vec c) {
  const double la = norm(a), lb = norm(b), lc = norm(c);
  const double volume = dot(a, cross(b, c));
  const double scale = la * lb * lc + dot(a, b) * lc + dot(b, c) * la + dot(c, a) * lb;
  return std::atan2(volume, scale);
}

inline Vec closest_on_segment(Vec p, Vec a, Vec b) {
  const Vec ab = b - a;
  const double length2 = dot(ab, ab);
  if (!(length2 > 0.0)) return a;
  return a + std::clamp(dot(p - a, ab) / length2, 0.0, 1.0) * ab;
}

Vec closest_on_edges(Vec p, const Triangle& t) {
  const Vec candidates[3] = {closest_on_segment(p, t.a, t.b), closest_on_segment(p, t.b, t.c),
                             closest_on_segment(p, t.c, t.a)};
  Vec best = candidates[0];
  for (const Vec& q : candidates)
    if (dot(p - q, p - q) < dot(p - best, p - best)) best = q;
  return best;
}

// Closest point of a triangle by the region of the plane that p lies over (Voronoi regions).
Vec closest_on_triangle(Vec p, const Triangle& t) {
  if (t.sliver) return closest_on_edges(p, t);
  const Vec ab = t.b - t.a, ac = t.c - t.a, ap = p - t.a;
  const double d1 = dot(ab, ap), d2 = dot(ac, ap);
  if (d1 <= 0.0 && d2 <= 0.0) return t.a;
  const Vec bp = p - t.b;
  const double d3 = dot(ab, bp), d4 = dot(ac, bp);
  if (d3 >= 0.0 && d4 <= d3) return t.b;
  const double vc = d1 * d4 - d3 * d2;
  if (vc <= 0.0 && d1 >= 0.0 && d3 <= 0.0) return t.a + (d1 / (d1 - d3)) * ab;
  const Vec cp = p - t.c;
  const double d5 = dot(ab, cp), d6 = dot(ac, cp);
  if (d6 >= 0.0 && d5 <= d6) return t.c;
  const double vb = d5 * d2 - d1 * d6;
  if (vb <= 0.0 && d2 >= 0.0 && d6 <= 0.0) return t.a + (d2 / (d2 - d6)) * ac;
  const double va = d3 * d6 - d5 * d4;
  if (va <= 0.0 && d4 - d3 >= 0.0 && d5 - d6 >= 0.0)
    return t.b + ((d4 - d3) / ((d4 - d3) + (d5 - d6))) * (t.c - t.b);
  const double sum = va + vb + vc;
  return t.a + (vb / sum) * ab + (vc / sum) * ac;
}

// A cluster of triangles seen from afar. With G(r) = r / (4 pi |r|^3), the winding number is
// the integral of n . G(x - q) dA; around the cluster's centre p it is
// dipole . G(p - q) + tensor : DG(p - q) + rest, and |rest| <= 3/(4 pi) * second moment / d^4
// where d is the distance of q from the ball of all the cluster's points, as |D^2 G| <= 6/(4 pi d^4).
struct Cluster {
  Vec centre;
  double radius, remainder;
  double change[2];      // over d^3 and d^4, how fast the expansion changes as q moves at most
  Vec dipole;            // integral of n dA, over 4 pi
  double diagonal[3];    // integral of (x - p)_i n_i dA, over 4 pi
  double mixed[3];       // xy, yz, zx: integral of (x - p)_i n_j + (x - p)_j n_i dA, over 4 pi
};

// The expansion, r from q to the centre; 1 / |r|^2 and 1 / |r|^3.
inline double far_field(const Cluster& c, Vec r, double inv2, double inv3) {
  const double trace = c.diagonal[0] + c.diagonal[1] + c.diagonal[2];
  const double quadratic = c.diagonal[0] * r.x * r.x + c.diagonal[1] * r.y * r.y +
                           c.diagonal[2] * r.z * r.z + c.mixed[0] * r.x * r.y +
                           c.mixed[1] * r.y * r.z + c.mixed[2] * r.z * r.x;
  return (dot(c.dipole, r) + trace - 3.0 * quadratic * inv2) * inv3;
}

struct Node {
  int left;            // index of the left child (the right one follows it), -1 in a leaf
  int first, count;    // its triangles
};

struct Box {
  Vec lo, hi;
};

inline double box_distance2(const Box& b, Vec p) {
  const double x = std::max({b.lo.x - p.x, 0.0, p.x - b.hi.x});
  const double y = std::max({b.lo.y - p.y, 0.0, p.y - b.hi.y});
  const double z = std::max({b.lo.z - p.z, 0.0, p.z - b.hi.z});
  return x * x + y * y + z * z;
}

// A box along its own axes around the triangles of a node: flat where they are flat, so that it is
// known how near they come without looking at them. In single precision, rounded outwards; the
// axes are unit vectors to 1e-6.
struct Slab {
  float centre[3], half[3];
  float axes[3][3];
};

// A lower bound of the squared distance of a point from what is in a slab.
inline double slab_distance2(const Slab& b, Vec p) {
  const double x = p.x - b.centre[0], y = p.y - b.centre[1], z = p.z - b.centre[2];
  double sum = 0.0;
  for (int k = 0; k < 3; ++k) {
    const double along = b.axes[k][0] * x + b.axes[k][1] * y + b.axes[k][2] * z;
    const double out = std::max(std::abs(along) - b.half[k], 0.0);
    sum += out * out;
  }
  return (1.0 - 1e-6) * sum;
}

inline double axis(Vec v, int k) { return k == 0 ? v.x : (k == 1 ? v.y : v.z); }

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
    Open heap[kSteps + 1];
    int size = 0;
    double value = 0.0, off = 0.0;  // at the centre, and by how much it may be another anywhere
    auto less = [](const Open& a, const Open& b) { return a.off < b.off; };
    auto add = [&](int index) {
      const Open open = seen(index, q, rho);
      value += open.value;
      off += open.off;
      if (open.node < 0) return;  // as exact as it gets
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

  // `exceeds` of n points with one threshold, points[order[i]]: all of a ball at once where it can
  // be said of all of it. `order` is changed.
  template <typename Point, typename Tell>
  void exceeds_all(const Point& point, int* order, int n, double threshold, const Tell& tell) const {
    // A question about several is worth so many steps for each of them.
    constexpr int kFew = 4, kParts = 4, kEach = 8;
    if (n <= kFew) {
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
    const int known = decide(0.5 * (lo + hi), 0.5 * norm(extent), threshold, std::min(kSteps, kEach * n));
    if (known >= 0) {
      for (int i = 0; i < n; ++i) tell(order[i], known == 1);
      return;
    }
    const int k = extent.x >= extent.y ? (extent.x >= extent.z ? 0 : 2)
                                       : (extent.y >= extent.z ? 1 : 2);
    std::sort(order, order + n, [&](int a, int b) { return axis(point(a), k) < axis(point(b), k); });
    for (int i = 0; i < kParts; ++i)
      exceeds_all(point, order + n * i / kParts, n * (i + 1) / kParts - n * i / kParts, threshold,
                  tell);
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
  // triangle that is likely near: it changes the time taken, not the answer.
  int closest(Vec p, int guess, Vec& point, double& distance) const {
    struct Open {
      double d2;
      int node;
    };
    Open stack[kStack];
    int top = 0, best = -1;
    double best2 = std::numeric_limits<double>::infinity();
    auto ask = [&](int i) {
      const Vec q = closest_on_triangle(p, triangles_[i]);
      const double d2 = dot(p - q, p - q);
      if (d2 < best2 ||
          (d2 == best2 && (best < 0 || triangles_[i].face < triangles_[best].face))) {
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

  int face(int triangle) const { return triangles_[triangle].face; }
  bool has_winding() const { return winding_; }

 private:
  // What a node adds to the winding number, how far that is off at most, and the node, or -1 where
  // nothing in it could be opened.
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
      const double off = c.remainder * inv4 +
                         rho * (c.change[0] * inv3 + (c.change[1] + 4.0 * c.remainder * inv) * inv4);
      if (node.left >= 0 || off < 1e-3) {
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
    slabs_[node] = flat(first, count, box);
    nodes_[node] = {-1, first, count};
    if (winding_) clusters_[node] = describe(first, count, box);
    if (count <= kLeaf) return;
    const Vec extent = middle.hi - middle.lo;
    const int k = extent.x >= extent.y ? (extent.x >= extent.z ? 0 : 2)
                                       : (extent.y >= extent.z ? 1 : 2);
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

  // Axes: the mean normal, the longest side of the box across it, and what is across both.
  Slab flat(int first, int count, const Box& box) const {
    Vec normal{0, 0, 0};
    for (int i = first; i < first + count; ++i) {
      const Triangle& t = triangles_[i];
      normal = normal + cross(t.b - t.a, t.c - t.a);
    }
    const Vec extent = box.hi - box.lo, middle = 0.5 * (box.lo + box.hi);
    const double size = norm(extent), length = norm(normal);
    Vec axes[3] = {{1, 0, 0}, {0, 1, 0}, {0, 0, 1}};
    if (length > 1e-9 * size * size) {  // else it faces every way, or is a sliver
      const Vec n = (1.0 / length) * normal;
      const Vec sides[3] = {{extent.x, 0, 0}, {0, extent.y, 0}, {0, 0, extent.z}};
      Vec longest{0, 0, 0};
      for (const Vec& side : sides) {
        const Vec across = side - dot(side, n) * n;
        if (dot(across, across) > dot(longest, longest)) longest = across;
      }
      if (norm(longest) > 1e-9 * size) {
        axes[0] = (1.0 / norm(longest)) * longest;
        axes[1] = cross(n, axes[0]);
        axes[2] = n;
      }
    }
    Slab s;
    double lo[3], hi[3];
    for (int k = 0; k < 3; ++k) {
      s.axes[k][0] = static_cast<float>(axes[k].x);
      s.axes[k][1] = static_cast<float>(axes[k].y);
      s.axes[k][2] = static_cast<float>(axes[k].z);
      lo[k] = std::numeric_limits<double>::infinity();
      hi[k] = -lo[k];
    }
    auto along = [&s](int k, Vec p) {
      return s.axes[k][0] * p.x + s.axes[k][1] * p.y + s.axes[k][2] * p.z;
    };
    for (int i = first; i < first + count; ++i) {
      const Triangle& t = triangles_[i];
      for (Vec p : {t.a - middle, t.b - middle, t.c - middle})
        for (int k = 0; k < 3; ++k) {
          const double x = along(k, p);
          lo[k] = std::min(lo[k], x);
          hi[k] = std::max(hi[k], x);
        }
    }
    Vec centre = middle;
    for (int k = 0; k < 3; ++k) centre = centre + 0.5 * (lo[k] + hi[k]) * axes[k];
    s.centre[0] = static_cast<float>(centre.x);
    s.centre[1] = static_cast<float>(centre.y);
    s.centre[2] = static_cast<float>(centre.z);
    const Vec shift = middle - Vec{s.centre[0], s.centre[1], s.centre[2]};
    const double room = 1e-12 * (size + norm(middle));
    for (int k = 0; k < 3; ++k) {
      const double off = along(k, shift);
      const double half = std::max(hi[k] + off, -(lo[k] + off)) + room;
      s.half[k] = std::nextafter(static_cast<float>(half), std::numeric_limits<float>::infinity());
    }
    return s;
  }

  Cluster describe(int first, int count, const Box& box) const {
    Cluster c{};
    double area = 0.0;
    Vec centre{0, 0, 0};
    for (int i = first; i < first + count; ++i) {
      const Triangle& t = triangles_[i];
      const double twice = norm(cross(t.b - t.a, t.c - t.a));
      area += twice;
      centre = centre + twice / 3.0 * (t.a + t.b + t.c);
    }
    c.centre = area > 0.0 ? (1.0 / area) * centre : 0.5 * (box.lo + box.hi);
    double moment = 0.0, radius2 = 0.0;
    double m[3][3] = {};
    for (int i = first; i < first + count; ++i) {
      const Triangle& t = triangles_[i];
      const Vec a = t.a - c.centre, b = t.b - c.centre, d = t.c - c.centre;
      const Vec sum = a + b + d, n = 0.5 * cross(b - a, d - a);
      c.dipole = c.dipole + n;
      for (int r = 0; r < 3; ++r)
        for (int s = 0; s < 3; ++s) m[r][s] += axis(sum, r) / 3.0 * axis(n, s);
      moment += norm(n) / 12.0 * (dot(a, a) + dot(b, b) + dot(d, d) + dot(sum, sum));
      radius2 = std::max({radius2, dot(a, a), dot(b, b), dot(d, d)});
    }
    c.dipole = (1.0 / kFourPi) * c.dipole;
    for (int r = 0; r < 3; ++r) {
      c.diagonal[r] = m[r][r] / kFourPi;
      c.mixed[r] = (m[r][(r + 1) % 3] + m[(r + 1) % 3][r]) / kFourPi;
    }
    c.radius = std::sqrt(radius2);
    c.remainder = 3.0 / kFourPi * moment;
    // |DG| <= 2 / (4 pi d^3), |D^2 G| <= 6 / (4 pi d^4).
    double square = 0.0;
    for (int r = 0; r < 3; ++r)
      square += c.diagonal[r] * c.diagonal[r] + 0.5 * c.mixed[r] * c.mixed[r];
    c.change[0] = 2.0 * norm(c.dipole);
    c.change[1] = 6.0 * std::sqrt(square);
    return c;
  }

  std::vector<Triangle> triangles_;    // in the tree's order
  std::vector<Node> nodes_;
  std::vector<Box> boxes_;
  std::vector<Slab> slabs_;
  std::vector<Cluster> clusters_;    // empty unless winding_
  bool winding_;
};

}  // namespace triangles
