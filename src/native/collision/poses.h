// Poses of all collision shapes: posed hulls, made on demand, and points of their surfaces.
//
// A `Poses` belongs to one set of coordinates (start of the substep, its end, ...). Kinematics are
// set by the caller; restart() then declares all shapes stale, and a shape is posed when it is
// first used: most shapes never are, because bounds decide about them. Skin hulls are skinned
// vertex by vertex (skin.h).
#pragma once
#include <cstdint>
#include <utility>
#include <vector>

#include "collision/collision_shape.h"
#include "contact/solver.h"
#include "dynamics/kinematic_tree.h"

namespace hp {

struct BoundingSphere {
  Vec3 center;
  double radius;
};

struct Poses {
  uint64_t stamp = 0;  // differs between any two poses of the process
  Kinematics kin;
  std::vector<double> way;  // of an end pose: how far each dof has gone since the start
  std::vector<PosedShape> posed;
  std::vector<char> fresh;  // per shape: `posed` is of this pose
  double placed = 0;        // what posing has cost since take_placed() was called, in skins

  // The kinematics have changed: nothing is posed yet.
  void restart(size_t shapes);
  // Shape i at this pose.
  const PosedShape& at(const std::vector<CollisionShape>& shapes, int i) {
    if (!fresh[i]) place(shapes[i], i);
    return posed[i];
  }

  double take_placed() { return std::exchange(placed, 0.0); }

  // A sphere that holds all of a shape, found from its influences without posing it.
  BoundingSphere bounding_sphere(const CollisionShape& m) const;
  const BoundingSphere& cached_bounding_sphere(const std::vector<CollisionShape>& shapes, int i);

  // The material point of a shape's surface that is at x now, and where it is at this pose. The
  // shape must be posed; a point of a skin hull moves with the nearest vertex.
  Material material(const CollisionShape& m, const PosedShape& at, Vec3 x) const;
  // The material point of a skin that is at x now and moves with vertex v.
  Material of_vertex(const CollisionShape& m, const PosedShape& at, int v, Vec3 x) const;
  Vec3 position(const CollisionShape& m, const PosedShape& at, const Material& point) const;
  // The same point as contacts need it: the bodies that carry it, and by how much (its Jacobian,
  // docs/physics.md, "The skin").
  Endpoint endpoint(const CollisionShape& m, const PosedShape& at, const Material& point) const;

 private:
  // Of skins with pose blend shapes: entries of the local rotations, minus the identity.
  struct BlendFeatures {
    const Skin* skin;
    std::vector<double> values;
  };
  void place(const CollisionShape& m, int i);
  void place_skin(const CollisionShape& m, PosedShape& out);
  const std::vector<double>& features(const Skin& s);
  std::shared_ptr<const std::vector<Endpoint::Bend>> blend_rates(const CollisionShape& m,
                                                                 const Endpoint& e,
                                                                 int vertex) const;

  std::vector<BlendFeatures> features_;
  std::vector<BoundingSphere> spheres_;  // a negative radius: not yet
};

}  // namespace hp
