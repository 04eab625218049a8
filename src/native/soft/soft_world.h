// What is soft, and the points by which things press on it. Plain data, filled in by assembly/soft_calls.h.
//
// A soft thing is its hard frame, which collides as everything does, under a layer: the geometry in
// CollisionWorld is the frame, and the visible surface lies a thickness above it. A shape presses on a layer
// by its samples: points of its hard surface, each with an outward normal and an area. Samples of what is
// soft have a layer of their own above them.
#pragma once
#include <array>
#include <vector>

#include "collision/collision_world.h"
#include "geometry/triangle_tree.h"
#include "soft/soft_law.h"

namespace hp {

struct SoftLayer {
  SoftLaw law;
  double thickness = 0;  // [m]; 0: hard
  // Of a mesh: the thickness at the corners of its faces, in the order in which they were given [m];
  // empty: the same everywhere.
  std::vector<Vec3> corners;
  bool soft() const { return thickness > 0; }
};

// A hull that is a box, possibly rounded: in the hull's frame.
struct FrameBox {
  bool is = false;
  Mat3 axes;  // in its columns
  Vec3 centre, half;
  static FrameBox of(const Convex& hull);
  // From the world to its axes, y = to x + shift, where the hull's frame has turned by R and its centre
  // lies there.
  struct Way {
    Mat3 to;
    Vec3 shift;
  };
  Way way(const Mat3& R, Vec3 centre_there, Vec3 hull_centre) const {
    const Mat3 to = transposed(R * axes);
    return {to, mul_t(axes, hull_centre - centre) - to * centre_there};
  }
};

// The points by which one shape presses on layers.
struct SurfaceSamples {
  std::vector<Vec3> points;        // in the frame of the shape's body; of a skin: at rest
  std::vector<Vec3> normals;       // unit, outward, in the same frame; of a skin: at rest
  std::vector<double> areas;       // [m^2]
  std::vector<double> half_width;  // half of their roots [m]
  std::vector<int> vertex;         // of a skin: in the shape
  std::vector<int> number;         // of a skin: in the order in which they were given
  std::vector<SoftLayer> layers;   // of a skin: of each sample; else: that of the shape
  // Of a skin: the joints that carry a sample, first_carrier[i] ... first_carrier[i + 1] - 1, by their
  // weights, of which none is 0.
  // In the order of the shape's influences.
  struct Carrier {
    int joint, body, influence;
    double weight;
  };
  std::vector<Carrier> carriers;
  // Of each carrier: its weight times the point at rest, and its weight.
  using Four = std::array<double, 4>;
  std::vector<Four> weighted;
  std::vector<int> first_carrier;
  double pitch = 0;     // distance of neighbours, about [m]
  double thickest = 0;  // layer above a sample [m]
  int size() const { return (int)normals.size(); }
};

// Samples of a person's skin as they were given, before its shapes are known to be complete.
struct SkinSamples {
  int person = 0;
  std::vector<int> vertices, parts;
  std::vector<double> areas, thickness, stiffness, damping;
  std::vector<Vec3> normals;
};

struct SoftWorld {
  std::vector<SoftLayer> of_static, of_shape;  // as many as there are, or fewer: the rest is hard
  std::vector<SurfaceSamples> samples;         // per shape, or fewer
  std::vector<SkinSamples> skins;
  // Of static meshes: the tree that points ask. Per static, where anything is soft.
  std::vector<std::shared_ptr<const triangles::Tree>> trees;

  // Of hulls; per static and per shape.
  std::vector<FrameBox> static_boxes, shape_boxes;
  std::vector<FrameBox::Way> static_ways;

  bool any() const { return any_; }
  const SoftLayer& layer_of_static(int i) const;
  const SoftLayer& layer_of_shape(int i) const;
  const SurfaceSamples& samples_of(int shape) const;
  // The number that the caller knows a sample by.
  int number(int shape, int sample) const;

  // When all shapes are there. Throws std::invalid_argument where samples name what does not exist.
  void finish(const CollisionWorld& world);
  // Which hulls are boxes.
  void find_boxes(const CollisionWorld& world);

 private:
  void place_skin(const CollisionWorld& world, const SkinSamples& skin);
  void find_carriers(const CollisionWorld& world);
  void build_trees(const CollisionWorld& world);

  bool any_ = false;
};

}  // namespace hp
