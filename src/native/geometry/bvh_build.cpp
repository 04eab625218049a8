// How the tree over a mesh is built, and shared by all that have the same mesh.
#include <cstdint>
#include <cstring>
#include <limits>
#include <map>
#include <mutex>
#include <stdexcept>

#include "geometry/bvh.h"
#include "tuning.h"

namespace hp {

namespace tune = tuning::geometry;

namespace {

double half_area(const Box3& b) {
  Vec3 d = b.hi - b.lo;
  return d.x < 0 ? 0 : d.x * d.y + d.y * d.z + d.z * d.x;
}

Box3 joined(Box3 a, const Box3& b) {
  a.lo = {std::min(a.lo.x, b.lo.x), std::min(a.lo.y, b.lo.y), std::min(a.lo.z, b.lo.z)};
  a.hi = {std::max(a.hi.x, b.hi.x), std::max(a.hi.y, b.hi.y), std::max(a.hi.z, b.hi.z)};
  return a;
}

void check_faces(const int* faces, int nf, int nv) {
  if (nf <= 0) throw std::invalid_argument("a mesh needs at least one triangle");
  for (size_t i = 0; i < 3 * (size_t)nf; i++)
    if (faces[i] < 0 || faces[i] >= nv)
      throw std::invalid_argument("a face names a vertex that does not exist");
}

struct Item {
  Box3 box;
  int face;
  double centre(int axis) const { return 0.5 * box.lo[axis] + 0.5 * box.hi[axis]; }
};

// Cuts items [first, last) in two along an axis.
struct Splitter {
  std::vector<Item>& items;
  const int first, last, axis;
  const double lo, scale;  // of bins
  static constexpr int kBins = tune::kSahBins;

  int bin(const Item& i) const { return std::min(kBins - 1, (int)(scale * (i.centre(axis) - lo))); }

  int in_halves() {
    std::sort(items.begin() + first, items.begin() + last, [&](const Item& a, const Item& b) {
      double x = a.centre(axis), y = b.centre(axis);
      return x < y || (x == y && a.face < b.face);
    });
    return first + (last - first) / 2;
  }

  // The first bin of the right side, by the binned surface-area heuristic; -1: no bin divides them.
  int best_bin() const {
    Box3 box[kBins];
    int count[kBins] = {};
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
    return at;
  }

  // Written out: which of std::partition's results comes out is the library's choice.
  int partition(int at) {
    int i = first, j = last;
    while (true) {
      while (i < j && bin(items[i]) < at) i++;
      while (i < j && bin(items[j - 1]) >= at) j--;
      if (i >= j) return i;
      std::swap(items[i], items[j - 1]);
    }
  }
};

// Sorts items [first, last) to two sides and returns where the second begins: by area, else in
// halves; in the middle as they are where their centres do not tell them apart. The same order on
// every platform.
int split(std::vector<Item>& items, int first, int last, const Box3& centres, bool by_area) {
  const int half = first + (last - first) / 2;
  Vec3 size = centres.hi - centres.lo;
  int axis = size.x >= size.y ? (size.x >= size.z ? 0 : 2) : (size.y >= size.z ? 1 : 2);
  double lo = centres.lo[axis], scale = tune::kSahBins / size[axis];
  if (!(size[axis] > 1e-12) || !std::isfinite(scale)) return half;
  Splitter s{items, first, last, axis, lo, scale};
  if (!by_area) return s.in_halves();
  const int at = s.best_bin();
  return at < 0 ? half : s.partition(at);
}

// FNV-1a, eight bytes at a time.
struct Hash {
  uint64_t value = 1469598103934665603ull;
  void mix(const void* data, size_t bytes) {
    const char* p = (const char*)data;
    for (; bytes >= 8; p += 8, bytes -= 8) {
      uint64_t word;
      std::memcpy(&word, p, 8);
      value = (value ^ word) * 0x9e3779b97f4a7c15ull;
      value ^= value >> 32;
    }
    for (; bytes; p++, bytes--) value = (value ^ (unsigned char)*p) * 1099511628211ull;
  }
};

}  // namespace

TriangleTree::TriangleTree(const double* vertices, int nv, const int* faces, int nf) {
  check_faces(faces, nf, nv);
  corner_.resize(3 * (size_t)nf);
  for (size_t i = 0; i < corner_.size(); i++) corner_[i] = load3(vertices + 3 * (size_t)faces[i]);
  build();
}

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
    if (node.count > tune::kBvhLeaf) {
      int middle = split(items, w.first, w.last, centres, w.depth < tune::kSahDepth);
      node.count = 0;
      node.left = id + 1;
      work.push_back({middle, w.last, w.depth + 1, id});
      work.push_back({w.first, middle, w.depth + 1, -1});
    }
    nodes_.push_back(node);
  }
  nodes_.shrink_to_fit();
  face_.resize(nf);
  for (int i = 0; i < nf; i++) face_[i] = items[i].face;
  order_corners();
}

// Puts corners in the order of the leaves: what a query reads together lies together.
void TriangleTree::order_corners() {
  std::vector<Vec3> corner(corner_.size());
  for (size_t i = 0; i < face_.size(); i++)
    for (int k = 0; k < 3; k++) corner[3 * i + k] = corner_[3 * (size_t)face_[i] + k];
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
  // The hash only narrows the choice: the tree that is returned has been compared.
  Hash hash;
  hash.value += (uint64_t)nv;
  hash.mix(vertices, 3 * sizeof(double) * (size_t)nv);
  hash.mix(faces, 3 * sizeof(int) * (size_t)nf);
  static std::mutex mutex;
  static std::multimap<uint64_t, std::weak_ptr<const TriangleTree>> known;
  {
    std::lock_guard<std::mutex> lock(mutex);
    for (auto it = known.begin(); it != known.end();)
      it = it->second.expired() ? known.erase(it) : std::next(it);
    auto range = known.equal_range(hash.value);
    for (auto it = range.first; it != range.second; ++it) {
      auto tree = it->second.lock();
      if (tree && tree->holds(vertices, faces, nf)) return tree;
    }
  }
  // Outside the lock: two threads that want the same new tree at once build one each.
  auto tree = std::make_shared<const TriangleTree>(vertices, nv, faces, nf);
  std::lock_guard<std::mutex> lock(mutex);
  known.emplace(hash.value, tree);
  return tree;
}

}  // namespace hp
