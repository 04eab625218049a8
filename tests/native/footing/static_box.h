// Static boxes, as convex hulls or as triangles, over a floor.
#pragma once
#include <vector>

#include "collision/collision_world.h"

namespace static_box {

inline hp::Static make(hp::Vec3 lo, hp::Vec3 hi, bool mesh) {
  hp::Static s;
  double xyz[24];
  for (int i = 0; i < 8; i++) {
    const hp::Vec3 x{i & 1 ? hi.x : lo.x, i & 2 ? hi.y : lo.y, i & 4 ? hi.z : lo.z};
    s.hull.vertices.push_back(x);
    hp::store3(xyz + 3 * i, x);
  }
  s.hull.finish();
  s.kind = hp::Static::Kind::Hull;
  if (!mesh) return s;
  const int faces[] = {0, 1, 3, 0, 3, 2, 4, 5, 7, 4, 7, 6, 0, 1, 5, 0, 5, 4,
                       2, 3, 7, 2, 7, 6, 0, 2, 6, 0, 6, 4, 1, 3, 7, 1, 7, 5};
  s.kind = hp::Static::Kind::Mesh;
  s.tree = hp::TriangleTree::shared(xyz, 8, faces, 12);
  return s;
}

// Things on a floor through the origin, whose unit normal is `up`.
inline hp::CollisionWorld world_of(std::vector<hp::Static> things, hp::Vec3 up = {0, 0, 1}) {
  hp::CollisionWorld world;
  hp::Static floor;
  floor.n = up;
  world.statics = std::move(things);
  world.statics.push_back(floor);
  for (hp::Static& s : world.statics)
    if (s.kind == hp::Static::Kind::Hull) s.posed.place(s.hull, {}, {});
  return world;
}

}  // namespace static_box
