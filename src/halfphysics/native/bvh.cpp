#include "bvh.h"

#include <numeric>
#include <stdexcept>

namespace hp {

namespace {

// Overlaps up to this deep count as touching: what was set down exactly on a surface [m].
constexpr double kTouch = 1e-4;
constexpr int kLeaf = 4;
constexpr int kMaxPlanes = 32;

double half_area(const Box3& b) {
  Vec3 d = b.hi - b.lo;
  return d.x < 0 ? 0 : d.x * d.y + d.y * d.z + d.z * d.x;
}

Box3 joined(Box3 a, const Box3& b) {
  a.lo = {std::min(a.lo.x, b.lo.x), std::min(a.lo.y, b.lo.y), std::min(a.lo.z, b.lo.z)};
  a.hi = {std::max(a.hi.x, b.hi.x), std::max(a.hi.y, b.hi.y), std::max(a.hi.z, b.hi.z)};
  return a;
}

double gap2(const Box3& a, const Box3& b) {
  double s = 0;
  for (int k = 0; k < 3; k++) {
    double g = std::max(0.0, std::max(a.lo[k] - b.hi[k], b.lo[k] - a.hi[k]));
    s += g * g;
  }
  return s;
}

// Largest n.x over a box.
double highest(const Box3& b, Vec3 n) {
  return (n.x > 0 ? b.hi.x : b.lo.x) * n.x + (n.y > 0 ? b.hi.y : b.lo.y) * n.y +
         (n.z > 0 ? b.hi.z : b.lo.z) * n.z;
}

struct Entry {
  double d2;
  int id;  // node, or -1 - triangle
  bool operator<(const Entry& o) const { return d2 > o.d2 || (d2 == o.d2 && id > o.id); }
};

}  // namespace

TriangleTree::TriangleTree(const double* vertices, int nv, const int* faces, int nf) {
  if (nf <= 0) throw std::invalid_argument("a mesh needs at least one triangle");
  corner_.resize(3 * (size_t)nf);
  centroid_.resize(nf);
  for (int t = 0; t < nf; t++) {
    for (int k = 0; k < 3; k++) {
      int v = faces[3 * t + k];
      if (v < 0 || v >= nv) throw std::invalid_argument("a face names a vertex that does not exist");
      corner_[3 * t + k] = load3(vertices + 3 * (size_t)v);
    }
    centroid_[t] = (1 / 3.0) * (corner_[3 * t] + corner_[3 * t + 1] + corner_[3 * t + 2]);
  }
  order_.resize(nf);
  std::iota(order_.begin(), order_.end(), 0);
  nodes_.reserve(nf);
  build(0, nf);
}

int TriangleTree::build(int first, int last) {
  int id = (int)nodes_.size();
  nodes_.emplace_back();
  Node node;
  node.first = first;
  node.count = last - first;
  Box3 centers;
  for (int i = first; i < last; i++) {
    for (int k = 0; k < 3; k++) node.box.add(corner_[3 * order_[i] + k]);
    centers.add(centroid_[order_[i]]);
  }
  if (node.count > kLeaf) {
    Vec3 size = centers.hi - centers.lo;
    int axis = size.x >= size.y ? (size.x >= size.z ? 0 : 2) : (size.y >= size.z ? 1 : 2);
    int middle = -1;
    if (size[axis] > 1e-12) {
      // Binned surface-area heuristic (Wald 2007).
      constexpr int kBins = 16;
      Box3 box[kBins];
      int count[kBins] = {};
      double scale = kBins / size[axis];
      auto bin = [&](int t) {
        return std::min(kBins - 1, (int)(scale * (centroid_[t][axis] - centers.lo[axis])));
      };
      for (int i = first; i < last; i++) {
        int b = bin(order_[i]);
        count[b]++;
        for (int k = 0; k < 3; k++) box[b].add(corner_[3 * order_[i] + k]);
      }
      double left[kBins];
      int n_left[kBins];
      Box3 sum;
      int n = 0;
      for (int b = 0; b < kBins; b++) {
        sum = joined(sum, box[b]);
        n += count[b];
        left[b] = half_area(sum);
        n_left[b] = n;
      }
      sum = {};
      n = 0;
      double best = 1e300;
      int split = -1;
      for (int b = kBins - 1; b > 0; b--) {
        sum = joined(sum, box[b]);
        n += count[b];
        double cost = left[b - 1] * n_left[b - 1] + half_area(sum) * n;
        if (n && n_left[b - 1] && cost < best) best = cost, split = b;
      }
      if (split > 0) {
        auto it = std::stable_partition(order_.begin() + first, order_.begin() + last,
                                        [&](int t) { return bin(t) < split; });
        middle = (int)(it - order_.begin());
      }
    }
    if (middle <= first || middle >= last) middle = (first + last) / 2;
    node.count = 0;
    node.left = build(first, middle);
    node.right = build(middle, last);
  }
  nodes_[id] = node;
  return id;
}

void TriangleTree::triangle(int t, Vec3 v[3]) const {
  for (int k = 0; k < 3; k++) v[k] = corner_[3 * (size_t)t + k];
}

namespace {

// The plane of the nearest points of a shape and a triangle; dist > reach where they are farther.
Plane plane_to(const Placed& a, const Vec3 v[3], int t, double reach) {
  double x[3] = {v[0].x, v[1].x, v[2].x}, y[3] = {v[0].y, v[1].y, v[2].y},
         z[3] = {v[0].z, v[1].z, v[2].z};
  Support tri{{x, y, z, 3}};
  Vec3 pa, pb, middle = (1 / 3.0) * (v[0] + v[1] + v[2]);
  double r = a.shape->radius, d = gjk(a.support(), tri, a.center - middle, pa, pb, reach + r);
  if (d > reach + r) return {{}, 0, d - r, t, false};
  if (d > 1e-9) {
    Vec3 n = (1 / d) * (pa - pb);
    double offset = std::max(dot(n, v[0]), std::max(dot(n, v[1]), dot(n, v[2])));
    return {n, offset, d - r, t, false};
  }
  // They touch or overlap: the smaller way out along the triangle's own normal.
  Vec3 n = cross(v[1] - v[0], v[2] - v[0]);
  double length = norm(n);
  if (length < 1e-14) return {{}, 0, 0, t, true};
  n = (1 / length) * n;
  double up = a.lowest(n) - dot(n, v[0]), down = a.lowest(-n) + dot(n, v[0]);
  Vec3 side = up >= down ? n : -n;
  double depth = std::max(up, down);
  return {side, dot(side, v[0]), depth, t, depth < -kTouch};
}

}  // namespace

void TriangleTree::planes(const Placed& a, double reach, std::vector<Plane>& out,
                          const std::vector<int>& without) const {
  out.clear();
  std::vector<Entry> heap;
  std::vector<Plane> known;  // planes of triangles whose distance has been computed
  std::vector<int> known_of;
  auto push = [&](double d2, int id) {
    heap.push_back({d2, id});
    std::push_heap(heap.begin(), heap.end());
  };
  auto behind = [&](const Box3& b) {
    for (const Plane& p : out)
      if (!p.overlaps && highest(b, p.n) <= p.offset + 1e-9) return true;
    return false;
  };
  double start = gap2(nodes_[0].box, a.box);
  if (start <= reach * reach) push(start, 0);
  while (!heap.empty() && (int)out.size() < kMaxPlanes) {
    std::pop_heap(heap.begin(), heap.end());
    Entry e = heap.back();
    heap.pop_back();
    if (e.id < 0) {
      int t = -1 - e.id;
      if (std::find(without.begin(), without.end(), t) != without.end()) continue;
      Vec3 v[3];
      triangle(t, v);
      bool culled = false;
      for (const Plane& p : out) {
        double o = p.offset + 1e-7;
        culled |= !p.overlaps && dot(p.n, v[0]) <= o && dot(p.n, v[1]) <= o && dot(p.n, v[2]) <= o;
      }
      if (culled) continue;
      auto it = std::find(known_of.begin(), known_of.end(), t);
      if (it == known_of.end()) {
        Plane p = plane_to(a, v, t, reach);
        if (p.dist > reach) continue;
        double d2 = p.dist > 0 ? p.dist * p.dist : 0;
        if (!heap.empty() && d2 > heap.front().d2) {
          known.push_back(p);
          known_of.push_back(t);
          push(d2, e.id);
          continue;
        }
        out.push_back(p);
      } else {
        out.push_back(known[it - known_of.begin()]);
      }
      continue;
    }
    const Node& node = nodes_[e.id];
    if (behind(node.box)) continue;
    if (node.left < 0) {
      for (int i = node.first; i < node.first + node.count; i++) {
        Vec3 v[3];
        triangle(order_[i], v);
        Box3 b;
        for (Vec3 p : v) b.add(p);
        double d2 = gap2(b, a.box);
        if (d2 <= reach * reach) push(d2, -1 - order_[i]);
      }
    } else {
      for (int child : {node.left, node.right}) {
        double d2 = gap2(nodes_[child].box, a.box);
        if (d2 <= reach * reach) push(d2, child);
      }
    }
  }
}

double TriangleTree::distance(const Placed& a, double range) const {
  double best = range;
  std::vector<Entry> heap;
  auto push = [&](const Box3& b, int id) {
    double d2 = gap2(b, a.box);
    if (best > 0 && d2 > best * best) return;
    heap.push_back({d2, id});
    std::push_heap(heap.begin(), heap.end());
  };
  push(nodes_[0].box, 0);
  while (!heap.empty()) {
    std::pop_heap(heap.begin(), heap.end());
    Entry e = heap.back();
    heap.pop_back();
    if (e.d2 > 0 && (best <= 0 || e.d2 > best * best)) break;
    const Node& node = nodes_[e.id];
    if (node.left >= 0) {
      push(nodes_[node.left].box, node.left);
      push(nodes_[node.right].box, node.right);
      continue;
    }
    for (int i = node.first; i < node.first + node.count; i++) {
      Vec3 v[3];
      triangle(order_[i], v);
      Plane p = plane_to(a, v, order_[i], std::max(best, 0.0));
      best = std::min(best, p.dist);
    }
  }
  return best;
}

}  // namespace hp
