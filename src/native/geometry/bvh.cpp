#include "geometry/bvh.h"

#include <cstdint>
#include <cstring>
#include <limits>
#include <map>
#include <mutex>
#include <numeric>
#include <stdexcept>

namespace hp {

namespace {

// Overlaps up to this deep count as touching: what was set down exactly on a surface [m].
constexpr double kTouch = 1e-4;
constexpr double kShort = 1e-5, kSeparates = 1e-6;  // [m]
constexpr int kLeaf = 4;
constexpr int kMaxPlanes = 64;
constexpr size_t kMostOutOfReach = 12;

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

void check_faces(const int* faces, int nf, int nv) {
  if (nf <= 0) throw std::invalid_argument("a mesh needs at least one triangle");
  for (size_t i = 0; i < 3 * (size_t)nf; i++)
    if (faces[i] < 0 || faces[i] >= nv)
      throw std::invalid_argument("a face names a vertex that does not exist");
}

}  // namespace

TriangleTree::TriangleTree(const double* vertices, int nv, const int* faces, int nf) {
  check_faces(faces, nf, nv);
  corner_.resize(3 * (size_t)nf);
  for (size_t i = 0; i < corner_.size(); i++) corner_[i] = load3(vertices + 3 * (size_t)faces[i]);
  build();
}

namespace {

constexpr int kBins = 16;
// Deeper than any sensible tree: from here on nodes are halved by count, so that no arrangement
// of triangles makes the depth more than this and the logarithm of their number.
constexpr int kDeep = 64;

struct Item {
  Box3 box;
  int face;
  double centre(int axis) const { return 0.5 * box.lo[axis] + 0.5 * box.hi[axis]; }
};

// Sorts items [first, last) to two sides and returns where the second begins: by the binned
// surface-area heuristic (Wald 2007), else in halves; in the middle as they are where their centres
// do not tell them apart. The same order on every platform.
int split(std::vector<Item>& items, int first, int last, const Box3& centres, bool by_area) {
  int half = first + (last - first) / 2;
  Vec3 size = centres.hi - centres.lo;
  int axis = size.x >= size.y ? (size.x >= size.z ? 0 : 2) : (size.y >= size.z ? 1 : 2);
  double lo = centres.lo[axis], scale = kBins / size[axis];
  if (!(size[axis] > 1e-12) || !std::isfinite(scale)) return half;
  if (!by_area) {
    std::sort(items.begin() + first, items.begin() + last, [&](const Item& a, const Item& b) {
      double x = a.centre(axis), y = b.centre(axis);
      return x < y || (x == y && a.face < b.face);
    });
    return half;
  }
  Box3 box[kBins];
  int count[kBins] = {};
  auto bin = [&](const Item& i) {
    return std::min(kBins - 1, (int)(scale * (i.centre(axis) - lo)));
  };
  for (int i = first; i < last; i++) {
    int b = bin(items[i]);
    count[b]++;
    box[b] = joined(box[b], items[i].box);
  }
  double left[kBins];
  int n_left[kBins], n = 0;
  Box3 sum;
  for (int b = 0; b < kBins; b++) {
    sum = joined(sum, box[b]);
    n += count[b];
    left[b] = half_area(sum);
    n_left[b] = n;
  }
  sum = {};
  n = 0;
  double best = std::numeric_limits<double>::infinity();
  int at = -1;
  for (int b = kBins - 1; b > 0; b--) {
    sum = joined(sum, box[b]);
    n += count[b];
    double cost = left[b - 1] * n_left[b - 1] + half_area(sum) * n;
    if (n && n_left[b - 1] && cost < best) best = cost, at = b;
  }
  if (at < 0) return half;
  // By hand: which of std::partition's results comes out is the library's choice.
  int i = first, j = last;
  while (true) {
    while (i < j && bin(items[i]) < at) i++;
    while (i < j && bin(items[j - 1]) >= at) j--;
    if (i >= j) return i;
    std::swap(items[i], items[j - 1]);
  }
}

}  // namespace

// Nodes are numbered depth first, the left child right after its parent.
void TriangleTree::build() {
  int nf = (int)(corner_.size() / 3);
  std::vector<Item> items(nf);
  for (int t = 0; t < nf; t++) {
    items[t].face = t;
    for (int k = 0; k < 3; k++) items[t].box.add(corner_[3 * (size_t)t + k]);
  }
  struct Work {
    int first, last, depth, parent;  // parent: whose right child this becomes, or -1
  };
  std::vector<Work> work{{0, nf, 0, -1}};
  nodes_.reserve(nf);
  while (!work.empty()) {
    Work w = work.back();
    work.pop_back();
    int id = (int)nodes_.size();
    if (w.parent >= 0) nodes_[w.parent].right = id;
    Node node;
    Box3 centres;
    for (int i = w.first; i < w.last; i++) {
      node.box = joined(node.box, items[i].box);
      centres.add({items[i].centre(0), items[i].centre(1), items[i].centre(2)});
    }
    node.first = w.first;
    node.count = w.last - w.first;
    if (node.count > kLeaf) {
      int middle = split(items, w.first, w.last, centres, w.depth < kDeep);
      node.count = 0;
      node.left = id + 1;
      work.push_back({middle, w.last, w.depth + 1, id});
      work.push_back({w.first, middle, w.depth + 1, -1});
    }
    nodes_.push_back(node);
  }
  nodes_.shrink_to_fit();
  // What a query reads together lies together.
  std::vector<Vec3> corner(corner_.size());
  face_.resize(nf);
  order_.resize(nf);
  std::iota(order_.begin(), order_.end(), 0);
  for (int i = 0; i < nf; i++) {
    face_[i] = items[i].face;
    for (int k = 0; k < 3; k++) corner[3 * (size_t)i + k] = corner_[3 * (size_t)face_[i] + k];
  }
  corner_.swap(corner);
}

bool TriangleTree::holds(const double* vertices, const int* faces, int nf) const {
  if (nf != size()) return false;
  for (int i = 0; i < nf; i++)
    for (int k = 0; k < 3; k++) {
      Vec3 v = load3(vertices + 3 * (size_t)faces[3 * (size_t)face_[i] + k]);
      if (std::memcmp(&v, &corner_[3 * (size_t)i + k], sizeof v)) return false;
    }
  return true;
}

std::shared_ptr<const TriangleTree> TriangleTree::shared(const double* vertices, int nv,
                                                         const int* faces, int nf) {
  check_faces(faces, nf, nv);
  // The hash only narrows the choice: what is returned has been compared.
  uint64_t hash = 1469598103934665603ull + (uint64_t)nv;
  auto mix = [&](const void* data, size_t bytes) {
    const char* p = (const char*)data;
    for (; bytes >= 8; p += 8, bytes -= 8) {
      uint64_t word;
      std::memcpy(&word, p, 8);
      hash = (hash ^ word) * 0x9e3779b97f4a7c15ull;
      hash ^= hash >> 32;
    }
    for (; bytes; p++, bytes--) hash = (hash ^ (unsigned char)*p) * 1099511628211ull;
  };
  mix(vertices, 3 * sizeof(double) * (size_t)nv);
  mix(faces, 3 * sizeof(int) * (size_t)nf);
  static std::mutex mutex;
  static std::multimap<uint64_t, std::weak_ptr<const TriangleTree>> known;
  {
    std::lock_guard<std::mutex> lock(mutex);
    for (auto it = known.begin(); it != known.end();)
      it = it->second.expired() ? known.erase(it) : std::next(it);
    auto range = known.equal_range(hash);
    for (auto it = range.first; it != range.second; ++it) {
      auto tree = it->second.lock();
      if (tree && tree->holds(vertices, faces, nf)) return tree;
    }
  }
  // Outside the lock: two threads that want the same new tree at once build one each.
  auto tree = std::make_shared<const TriangleTree>(vertices, nv, faces, nf);
  std::lock_guard<std::mutex> lock(mutex);
  known.emplace(hash, tree);
  return tree;
}

void TriangleTree::triangle(int t, Vec3 v[3]) const {
  for (int k = 0; k < 3; k++) v[k] = corner_[3 * (size_t)t + k];
}

namespace {

// Point of a triangle nearest to p (Ericson 2005, 5.1.5).
Vec3 nearest_on(const Vec3 v[3], Vec3 p) {
  Vec3 ab = v[1] - v[0], ac = v[2] - v[0], ap = p - v[0];
  double d1 = dot(ab, ap), d2 = dot(ac, ap);
  if (d1 <= 0 && d2 <= 0) return v[0];
  Vec3 bp = p - v[1];
  double d3 = dot(ab, bp), d4 = dot(ac, bp);
  if (d3 >= 0 && d4 <= d3) return v[1];
  double vc = d1 * d4 - d3 * d2;
  if (vc <= 0 && d1 >= 0 && d3 <= 0) return v[0] + (d1 / (d1 - d3)) * ab;
  Vec3 cp = p - v[2];
  double d5 = dot(ab, cp), d6 = dot(ac, cp);
  if (d6 >= 0 && d5 <= d6) return v[2];
  double vb = d5 * d2 - d1 * d6;
  if (vb <= 0 && d2 >= 0 && d6 <= 0) return v[0] + (d2 / (d2 - d6)) * ac;
  double va = d3 * d6 - d5 * d4;
  if (va <= 0 && d4 >= d3 && d5 >= d6)
    return v[1] + ((d4 - d3) / ((d4 - d3) + (d5 - d6))) * (v[2] - v[1]);
  double sum = va + vb + vc;
  return sum > 0 ? v[0] + (vb / sum) * ab + (vc / sum) * ac : v[0];
}

// The plane of the nearest points of a shape and a triangle; dist > reach where they are farther.
Plane plane_to(const PosedShape& a, const Vec3 v[3], int t, double reach, Vec3 guess = {}) {
  double x[3] = {v[0].x, v[1].x, v[2].x}, y[3] = {v[0].y, v[1].y, v[2].y},
         z[3] = {v[0].z, v[1].z, v[2].z};
  Support tri{{x, y, z, 3}};
  Vec3 pa, pb;
  if (norm2(guess) == 0) guess = a.center - nearest_on(v, a.center);
  double r = a.hull->radius, d = gjk(a.support(), tri, guess, pa, pb, reach + r);
  if (d > reach + r) {
    Vec3 n = pa - pb;
    return {n, std::max(dot(n, v[0]), std::max(dot(n, v[1]), dot(n, v[2]))), d - r, t, false};
  }
  if (d > 1e-9) {
    Vec3 n = (1 / d) * (pa - pb);
    double offset = std::max(dot(n, v[0]), std::max(dot(n, v[1]), dot(n, v[2])));
    // A line of rounding's length may point anywhere: only one that separates counts.
    if (d > kShort || a.lowest(n) - offset > d - r - kSeparates) return {n, offset, d - r, t, false};
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

bool TriangleTree::planes(const PosedShape& a, double reach, std::vector<Plane>& out,
                          const std::vector<int>& without) const {
  // What is measured and what waits, kept for the next call: nothing is allocated once warm.
  struct Known {  // a triangle whose distance has been computed, and who waits for its turn
    Plane plane;
    int first = -1;
  };
  struct Waiting {
    Entry entry;
    int next;
  };
  static thread_local std::vector<Entry> heap;
  static thread_local std::vector<Known> known;
  static thread_local std::vector<Waiting> waiting;
  static thread_local std::vector<Plane> out_of_reach;  // nothing behind these is within reach
  heap.clear();
  known.clear();
  waiting.clear();
  out_of_reach.clear();

  auto left_out = [&](int t) {
    return std::find(without.begin(), without.end(), t) != without.end();
  };
  auto push = [&](double d2, int id) {
    heap.push_back({d2, id});
    std::push_heap(heap.begin(), heap.end());
  };
  auto square = [](const Plane& p) { return p.dist > 0 ? p.dist * p.dist : 0; };
  // Culled by what is found, or set aside: what lies behind a plane that is known is not nearer
  // than that plane's triangle, and culled with it if that is then found.
  auto settled = [&](const Entry& e, auto behind) {
    for (const Plane& p : out)
      if (!p.overlaps && behind(p)) return true;
    for (const Plane& p : out_of_reach)
      if (behind(p)) return true;
    for (Known& k : known) {
      if (k.plane.overlaps || square(k.plane) <= e.d2 || !behind(k.plane)) continue;
      waiting.push_back({e, k.first});
      k.first = (int)waiting.size() - 1;
      return true;
    }
    return false;
  };
  auto node_settled = [&](const Entry& e) {
    const Box3& box = nodes_[e.id].box;
    return settled(e, [&](const Plane& p) { return highest(box, p.n) <= p.offset + 1e-9; });
  };
  auto triangle_settled = [&](const Entry& e, const Vec3 v[3]) {
    return settled(e, [&](const Plane& p) {
      double o = p.offset + 1e-7;
      return dot(p.n, v[0]) <= o && dot(p.n, v[1]) <= o && dot(p.n, v[2]) <= o;
    });
  };

  for (const Plane& old : out) {
    if (left_out(old.triangle)) continue;
    Vec3 v[3];
    triangle(old.triangle, v);
    Plane p = plane_to(a, v, old.triangle, reach, old.n);
    if (p.dist > reach) {
      out_of_reach.push_back(p);
    } else {
      known.push_back({p, -1});
      push(square(p), -1 - old.triangle);
    }
  }
  out.clear();
  double start = gap2(nodes_[0].box, a.box);
  if (start <= reach * reach) push(start, 0);
  while (!heap.empty() && (int)out.size() < kMaxPlanes) {
    std::pop_heap(heap.begin(), heap.end());
    const Entry e = heap.back();
    heap.pop_back();
    if (e.id >= 0) {
      if (node_settled(e)) continue;
      const Node& node = nodes_[e.id];
      if (node.left >= 0) {
        for (int child : {node.left, node.right}) {
          Entry c{std::max(gap2(nodes_[child].box, a.box), e.d2), child};
          if (c.d2 <= reach * reach && !node_settled(c)) push(c.d2, c.id);
        }
        continue;
      }
      for (int i = node.first; i < node.first + node.count; i++) {
        Vec3 v[3];
        triangle(order_[i], v);
        Box3 box;
        for (Vec3 p : v) box.add(p);
        Entry c{std::max(gap2(box, a.box), e.d2), -1 - order_[i]};
        if (c.d2 <= reach * reach && !left_out(order_[i]) && !triangle_settled(c, v))
          push(c.d2, c.id);
      }
      continue;
    }
    const int t = -1 - e.id;
    Vec3 v[3];
    triangle(t, v);
    auto it = std::find_if(known.begin(), known.end(),
                           [&](const Known& k) { return k.plane.triangle == t; });
    if (it != known.end()) {
      if (e.d2 < square(it->plane) * (1 - 1e-12)) continue;  // its turn comes
      bool culled = false;
      for (const Plane& p : out) {
        double o = p.offset + 1e-7;
        culled |= !p.overlaps && dot(p.n, v[0]) <= o && dot(p.n, v[1]) <= o && dot(p.n, v[2]) <= o;
      }
      if (!culled) {
        out.push_back(it->plane);
        it->first = -1;  // culled with it
        continue;
      }
      // Culled itself, it holds nobody back.
      int w = it->first;
      it->plane.dist = 0;
      for (; w >= 0; w = waiting[w].next) push(std::max(waiting[w].entry.d2, e.d2), waiting[w].entry.id);
      it->first = -1;
      continue;
    }
    if (triangle_settled(e, v)) continue;
    Plane p = plane_to(a, v, t, reach);
    if (p.dist > reach) {
      if (out_of_reach.size() < kMostOutOfReach) out_of_reach.push_back(p);
      continue;
    }
    if (!heap.empty() && square(p) > heap.front().d2) {
      known.push_back({p, -1});
      push(square(p), e.id);
    } else {
      out.push_back(p);
    }
  }
  return heap.empty();
}

double TriangleTree::distance(const PosedShape& a, double range, const std::vector<Plane>& near) const {
  double best = range;
  static thread_local std::vector<Entry> heap;
  // What lies behind a plane that was measured is no nearer than that, and so no nearer than the best.
  static thread_local std::vector<Plane> measured;
  heap.clear();
  measured.clear();
  auto measure = [&](int t, const Vec3 v[3]) {
    Plane p = plane_to(a, v, t, std::max(best, 0.0));
    best = std::min(best, p.dist);
    if (!p.overlaps && norm2(p.n) > 0 && measured.size() < kMostOutOfReach) measured.push_back(p);
  };
  auto push = [&](int id) {
    const Box3& box = nodes_[id].box;
    double d2 = gap2(box, a.box);
    if (best > 0 && d2 > best * best) return;
    for (const Plane& p : measured)
      if (highest(box, p.n) <= p.offset) return;
    heap.push_back({d2, id});
    std::push_heap(heap.begin(), heap.end());
  };
  for (const Plane& p : near) {
    Vec3 v[3];
    triangle(p.triangle, v);
    measure(p.triangle, v);
  }
  push(0);
  while (!heap.empty()) {
    std::pop_heap(heap.begin(), heap.end());
    Entry e = heap.back();
    heap.pop_back();
    if (e.d2 > 0 && (best <= 0 || e.d2 > best * best)) break;
    const Node& node = nodes_[e.id];
    if (node.left >= 0) {
      push(node.left);
      push(node.right);
      continue;
    }
    for (int i = node.first; i < node.first + node.count; i++) {
      Vec3 v[3];
      triangle(order_[i], v);
      bool behind = false;
      for (const Plane& p : measured)
        behind |= dot(p.n, v[0]) <= p.offset && dot(p.n, v[1]) <= p.offset &&
                  dot(p.n, v[2]) <= p.offset;
      if (!behind) measure(order_[i], v);
    }
  }
  return best;
}

double TriangleTree::winding(Vec3 p) const {
  double sum = 0;
  for (size_t t = 0; t < corner_.size(); t += 3) {
    const Vec3 a = corner_[t] - p, b = corner_[t + 1] - p, c = corner_[t + 2] - p;
    const double x = norm(a), y = norm(b), z = norm(c);
    sum += std::atan2(dot(a, cross(b, c)), x * y * z + dot(a, b) * z + dot(b, c) * x + dot(c, a) * y);
  }
  return sum / (2 * M_PI);
}

}  // namespace hp
