// How near points and triangles are to the shapes by which an item of a scene (here: a thing) touches,
// for contact labels. Nothing here changes a simulation.
#pragma once
#include <vector>

#include "geometry/triangle_tree.h"
#include "math/vec.h"

namespace hp {

// A shape that touches, in its thing's frame. Distances of solids are 0 inside.
struct TouchingShape {
  enum class Kind { Plane, Box, Capsule, Cylinder, Hull, Surface };
  Kind kind;
  Mat3 R;
  Vec3 pos;
  // Plane: normal and offset. Box: half extents. Capsule and cylinder: (radius, half length).
  Vec3 size;
  double offset = 0;
  const triangles::Tree* tree = nullptr;  // of hulls and surfaces
  std::vector<Vec3> normals;              // of a hull's faces, outward
  std::vector<double> offsets;

  // Lowers `least` (n) to the distances of points in the thing's frame, those that are under it; what is
  // over `limit` may be any number over it.
  void lower(const Vec3* points, int n, double limit, double* least) const;
};

// A thing: its shapes together.
struct TouchingThing {
  std::vector<TouchingShape> shapes;
  void distances(const Vec3* points, int n, double limit, double* out) const;
  // Whether a point in the thing's frame is at most so far away.
  bool within(Vec3 point, double reach) const;
};

// Points in cells of a box, to ask for those in a part of it.
class PointGrid {
 public:
  explicit PointGrid(std::vector<Vec3> points);
  const std::vector<Vec3>& points() const { return points_; }
  double cell_size() const { return size_; }
  // Calls tell(i) for the points in cells that a box meets: all in the box, and more.
  template <typename Tell>
  void in_box(const Box3& box, const Tell& tell) const {
    if (points_.empty() || !box.meets(box_)) return;
    int lo[3], hi[3];
    for (int k = 0; k < 3; k++) lo[k] = cell(box.lo[k], k), hi[k] = cell(box.hi[k], k);
    for (int x = lo[0]; x <= hi[0]; x++)
      for (int y = lo[1]; y <= hi[1]; y++) {
        const int row = (x * count_[1] + y) * count_[2];
        for (int i = first_[row + lo[2]]; i < first_[row + hi[2] + 1]; i++) tell(order_[i]);
      }
  }

 private:
  int cell(double x, int k) const {
    const double c = (x - box_.lo[k]) * per_length_;
    return c <= 0 ? 0 : c >= count_[k] ? count_[k] - 1 : (int)c;
  }
  std::vector<Vec3> points_;
  Box3 box_;
  double size_ = 1, per_length_ = 1;
  int count_[3] = {1, 1, 1};
  std::vector<int> first_, order_;
};

// Rows that were found, frame by frame.
struct NearRows {
  std::vector<int> frame, vertex, nearest;
  std::vector<double> distance, point;
};

// A skin in some frames of which some vertices are there: posed (t, n, 3) in the world, the vertices of
// each group one after the other.
struct PosedSkin {
  const double* x;
  int frames, n;
  const int* first;            // where each group starts (groups + 1)
  const unsigned char* close;  // which groups may be near in which frame (t, groups)
  int groups;
};

// Where a thing is in each frame, or in all of them: position (3) and turn (9).
struct Placing {
  const double *position, *turn;
  bool one;
};

// What is asked: vertices of the skin that are at most `reach` from a thing; with `points` also those
// of them that are at most `reach` from the triangles `faces` (n_faces, 3) of the skin.
struct NearQuery {
  const TouchingThing& thing;
  const PosedSkin& skin;
  const Placing& placing;
  double reach;             // [m]
  const PointGrid* points;  // on the thing; null: not asked
  double off;               // no point is farther than this outside of the thing [m]
  const int* faces;
  int n_faces;
};

void find_near(const NearQuery& query, NearRows& of_skin, NearRows& of_points);

}  // namespace hp
