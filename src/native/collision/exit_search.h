// The smallest displacement that takes a group of shapes out of an obstacle, onto the right side.
//
// Directions tried: the normals of faces nearby (of a mesh: of triangles near the group, both ways)
// and the 26 directions of a grid. Along all of them displacements grow in strides up to a limit until
// the group fits along one, and the last stride is bisected; the shortest wins. A search that may not
// cost more ends before the limit: what is longer is not found. A displacement fits if
//
// - every shape of the group is clear of the obstacle,
// - of a static: every hull is on the side of its joint (an object: on its own side), no joint that
//   leaves passes through the static, and the bones between bodies that leave and bodies that stay
//   do not cross it,
// - no shape of the group, nor of the bodies between it and the root, enters another static that it
//   is clear of now. If no displacement fits, this last condition is dropped.
#pragma once
#include <utility>
#include <vector>

#include "collision/overlap_groups.h"

namespace hp {

struct Exit {
  Vec3 displacement;  // [m]; zero: none was found
  double length = 0;  // [m]
};

class ExitSearch {
 public:
  // `avoid`: a unit direction that has been tried before, or zero. It costs `most_tests` about, which
  // are added to `tests` (geometry/bvh.h).
  ExitSearch(const CollisionWorld& world, const Model& m, Poses& start, const Obstacle& o,
             const OverlapGroup& group, Vec3 avoid, size_t most_tests, size_t& tests);
  Exit run();

 private:
  void find_free_shapes();
  bool on_right_side(Vec3 shift);
  bool enters_another(Vec3 shift);
  bool fits(Vec3 shift);
  void find_directions();
  void add_direction(Vec3 n);
  Exit search();
  void refine(Vec3 w, double bad, double good, Exit& best);

  const CollisionWorld& world_;
  const Model& model_;
  Poses& start_;
  const Obstacle& obstacle_;
  const OverlapGroup& group_;
  const Vec3 avoid_;
  const size_t most_tests_;
  size_t& tests_;
  const bool person_;
  std::vector<Vec3> directions_;
  // Shapes that carry the group or belong to it, and the statics that they are clear of.
  std::vector<std::pair<int, Obstacle>> free_;
  size_t last_blocked_ = 0;         // the shape of the group that did not fit last is tried first
  bool others_too_ = true;          // other statics count
  bool only_others_block_ = false;  // a displacement would fit, were it not for them
};

}  // namespace hp
