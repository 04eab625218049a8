// What a shape overlaps: a static, or an object where it is at the start.
#pragma once
#include "collision/collision_world.h"

namespace hp {

struct Obstacle {
  int other_static = -1, other_shape = -1, name = 0;
  const Static* fixed = nullptr;  // one of the two
  const PosedShape* object = nullptr;

  static Obstacle of_static(const CollisionWorld& world, int other_static);
  static Obstacle of_shape(const CollisionWorld& world, Poses& start, int other_shape);

  const PosedShape& posed() const { return object ? *object : fixed->posed; }
  bool is(Static::Kind kind) const { return fixed && fixed->kind == kind; }
  bool meets(const Box3& box) const;
  // Is the shape clear of it by `range` [m]? What it costs is added to `tests` (geometry/bvh.h).
  bool clear(const PosedShape& a, double range, size_t& tests) const;
  // Does the straight line from a to b meet it?
  bool crosses(Vec3 a, Vec3 b, size_t& tests) const;
};

}  // namespace hp
