// Nodes and triangles of a tree that a search has yet to look at, nearest first.
#pragma once

#include <algorithm>
#include <vector>

namespace hp {

struct TreeEntry {
  double d2;  // lower bound of the squared distance
  int id;     // node, or -1 - triangle
  bool operator<(const TreeEntry& o) const { return d2 > o.d2 || (d2 == o.d2 && id > o.id); }
};

struct TreeQueue {
  std::vector<TreeEntry> heap;
  void push(double d2, int id) {
    heap.push_back({d2, id});
    std::push_heap(heap.begin(), heap.end());
  }
  TreeEntry pop() {
    std::pop_heap(heap.begin(), heap.end());
    const TreeEntry e = heap.back();
    heap.pop_back();
    return e;
  }
};

}  // namespace hp
