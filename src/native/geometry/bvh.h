// Bounding-volume tree over triangles, and the separating planes between a convex shape and them.
#pragma once
#include <memory>
#include <vector>

#include "geometry/convex.h"

namespace hp {

struct Plane {
  Vec3 n;           // unit, towards the convex shape
  double offset;    // the triangle lies in n.x <= offset
  double dist;      // of the rounded shape from the triangle; negative: overlap along n
  int triangle;     // its number in the tree
  bool overlaps;    // the shape meets the triangle deeper than a touch
};

class TriangleTree {
 public:
  // Any soup: open, non-manifold, duplicated, degenerate triangles. Vertices in the world frame.
  TriangleTree(const double* vertices, int nv, const int* faces, int nf);
  // The tree of these triangles: the one that is there already, if somebody holds it, else a new
  // one. Told apart by content, bit for bit. Any thread may ask.
  static std::shared_ptr<const TriangleTree> shared(const double* vertices, int nv,
                                                    const int* faces, int nf);

  // Planes that together separate `a` from every triangle within `reach` of it: nearest triangle
  // first; what lies behind a plane already found is culled. Triangles `without` are left out.
  // What `out` holds on entry, from a pose nearby, is looked at first: it is likely to be it again.
  // False if there were more planes than are kept: the farthest are missing.
  bool planes(const PosedShape& a, double reach, std::vector<Plane>& out,
              const std::vector<int>& without = {}) const;
  // Smallest distance of `a` from the triangles, up to `range`; `range` if none is nearer, <= 0
  // where it meets one. The triangles of `near` are looked at first.
  double distance(const PosedShape& a, double range, const std::vector<Plane>& near = {}) const;

  // How often the triangles wind around p: 1 inside a closed mesh, 0 outside; between where it is open
  // (Jacobson et al. 2013). Looks at all of them.
  double winding(Vec3 p) const;

  // Triangles are numbered in the order of the leaves; `face` is the index into the faces given.
  void triangle(int t, Vec3 v[3]) const;
  int face(int t) const { return face_[t]; }
  int size() const { return (int)face_.size(); }
  const Box3& box() const { return nodes_[0].box; }

 private:
  struct Node {
    Box3 box;
    int left = -1, right = -1, first = 0, count = 0;
  };
  void build();
  bool holds(const double* vertices, const int* faces, int nf) const;

  std::vector<Vec3> corner_;  // three per triangle, in the order of the leaves
  std::vector<int> face_;     // index into the faces given
  std::vector<int> order_;    // of the leaves' triangles: 0, 1, 2, ...
  std::vector<Node> nodes_;
};

}  // namespace hp
