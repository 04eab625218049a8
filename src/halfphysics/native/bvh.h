// Bounding-volume tree over triangles, and the separating planes between a convex shape and them.
#pragma once
#include <vector>

#include "convex.h"

namespace hp {

struct Plane {
  Vec3 n;           // unit, towards the convex shape
  double offset;    // the triangle lies in n.x <= offset
  double dist;      // of the rounded shape from the triangle; negative: overlap along n
  int triangle;     // index into the faces given
  bool overlaps;    // the shape meets the triangle deeper than a touch
};

class TriangleTree {
 public:
  // Any soup: open, non-manifold, duplicated, degenerate triangles. Vertices in the world frame.
  TriangleTree(const double* vertices, int nv, const int* faces, int nf);

  // Planes that together separate `a` from every triangle within `reach` of it: nearest triangle
  // first; what lies behind a plane already found is culled. Triangles `without` are left out.
  void planes(const Placed& a, double reach, std::vector<Plane>& out,
              const std::vector<int>& without = {}) const;
  // Smallest distance of `a` from the triangles, up to `range`; `range` if none is nearer, <= 0
  // where it meets one.
  double distance(const Placed& a, double range) const;

  void triangle(int t, Vec3 v[3]) const;
  const Box3& box() const { return nodes_[0].box; }

 private:
  struct Node {
    Box3 box;
    int left = -1, right = -1, first = 0, count = 0;
  };
  int build(int first, int last);

  std::vector<Vec3> corner_;  // three per triangle, original order
  std::vector<Vec3> centroid_;
  std::vector<int> order_;
  std::vector<Node> nodes_;
};

}  // namespace hp
