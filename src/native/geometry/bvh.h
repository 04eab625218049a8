// A bounding-volume hierarchy over the triangles of static geometry, for queries by convex shapes:
// separating planes and distances. (geometry/triangle_tree.h is the one that points ask.)
//
// *Built* by the surface-area heuristic in 16 bins (Wald 2007, "On fast construction of SAH-based
// bounding volume hierarchies"), in the same order on every platform. Any soup will do: open,
// non-manifold, duplicated, degenerate triangles.
//
// *Planes.* All triangles within reach of a shape are to be kept apart from it by as few planes as
// possible: a foot on a finely divided floor needs one. Nodes and triangles are visited in the
// order of their distance (lower bounds by boxes, then GJK); the nearest triangle's plane comes
// first, and whatever lies wholly behind a plane already found is culled, because the plane keeps
// the shape from that too. The planes hold for displacements up to that reach.
//
// Lengths in [m].
#pragma once
#include <memory>
#include <vector>

#include "geometry/convex.h"

namespace hp {

// Separates a convex shape from a triangle.
struct Plane {
  Vec3 n;         // unit, towards the convex shape
  double offset;  // the triangle lies in n.x <= offset
  double dist;    // of the rounded shape from the triangle; negative: overlap along n
  int triangle;   // its number in the tree
  bool overlaps;  // the shape meets the triangle deeper than a touch
};

// Directions that separated a shape from triangles when last asked, longest ago first.
struct SeparatingAxes {
  static constexpr int kMost = 3;
  Vec3 n[kMost];  // unit, towards the shape; zero: none
  int next = 0;   // the one that is replaced next
};

class TriangleTree {
 public:
  // Vertices (nv, 3) in the world frame, faces (nf, 3) of their indices.
  TriangleTree(const double* vertices, int nv, const int* faces, int nf);
  // The tree of these triangles: one that exists already, if it is still in use, else a new one.
  // Trees are told apart by content, bit for bit. Thread-safe.
  static std::shared_ptr<const TriangleTree> shared(const double* vertices, int nv,
                                                    const int* faces, int nf);

  // Planes that together separate `a` from every triangle within `reach` of it, nearest triangle
  // first. Triangles `without` are left out. The triangles of the planes that `out` holds on entry,
  // from a pose nearby, are measured first: they are likely to be the ones again. Returns the reach
  // that the planes hold for [m]: less than was asked where they are too many (tuning.h,
  // kManyPlanes); `a` must then move no farther than that before it asks again. What the search
  // costs is added to `tests`: tests of boxes and triangles against planes.
  double planes(const PosedShape& a, double reach, std::vector<Plane>& out,
                const std::vector<int>& without = {}, size_t* tests = nullptr) const;
  // Smallest distance of `a` from the triangles, up to `range`; `range` if none is nearer, <= 0
  // where it meets one. The triangles of `near` are measured first.
  double distance(const PosedShape& a, double range, const std::vector<Plane>& near = {}) const;
  // Is a triangle nearer to `a` than `range`? The first one that is ends the search. What it costs is
  // added to `tests`.
  bool nearer(const PosedShape& a, double range, size_t& tests) const;
  // The plane of the nearest triangle, of those that it meets the one along whose normal it is deepest; false,
  // and `out` as it was, if none is nearer than `range`.
  bool nearest(const PosedShape& a, double range, Plane& out, size_t& tests) const;
  // A lower bound of the distance of `a` from the triangles, each of which some direction separates
  // from it; where none does, minus the depth. Directions are sought for up to `look`; the result
  // does not depend on those of `axes`, but for the size of a positive bound. What it costs is added to
  // `tests`.
  // `least`: depths are the least that any direction says, else, where GJK has none, those along the triangle's
  // own normal: too much for one that is met by its edge.
  double gap(const PosedShape& a, double look, SeparatingAxes& axes, size_t& tests,
             bool least = false) const;

  // Height of the highest triangle straight below `from` whose unit normal has a vertical part of over
  // `least_z`, up or down; -1e300: none.
  double below(Vec3 from, double least_z) const;

  // The triangles whose bounding boxes meet a box, in the order of the leaves.
  std::vector<int> meeting(const Box3& box) const;

  // How often the triangles wind around p: 1 inside a closed mesh, 0 outside, between where it is
  // open (generalised winding number: Jacobson et al. 2013). Sums over all triangles.
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
  struct PlaneSearch;
  struct DistanceSearch;
  void build();
  void order_corners();
  bool holds(const double* vertices, const int* faces, int nf) const;

  std::vector<Vec3> corner_;  // three per triangle, in the order of the leaves
  std::vector<int> face_;     // index into the faces given
  std::vector<Node> nodes_;
};

}  // namespace hp
