// How far a point is from the hard frame of a layer, and what the layer is there.
//
// Exact for half-spaces, convex hulls (GJK) and triangles (a tree). Points lie outside of frames: the
// contact of the frames keeps them out. Lengths in [m].
#pragma once
#include "collision/poses.h"
#include "soft/near_samples.h"
#include "soft/soft_world.h"

namespace hp {

struct FramePoint {
  double distance = 0;
  Vec3 n;                // unit, from the nearest point of the frame to the point asked for
  Vec3 at;               // that nearest point
  double thickness = 0;  // of the layer above it
  int triangle = -1;     // of a mesh: for the next search nearby to begin with
};

class FrameDistance {
 public:
  // The frame of a static, or of a shape at a pose.
  static FrameDistance of_static(const CollisionWorld& world, const SoftWorld& soft, int i);
  static FrameDistance of_shape(const CollisionWorld& world, const SoftWorld& soft, Poses& pose,
                                int i);
  // The nearest point of the frame to x, if it is within `within`; else false. `triangle`: a guess
  // that saves time, or -1.
  bool nearest(Vec3 x, double within, int triangle, FramePoint& out) const;
  // Is x within a frame that is a box? Then `nearest` does not know it, however far `within` reaches.
  bool holds(Vec3 x) const;
  // Of planes and boxes, all samples at once: the same, by their hard points.
  bool knows_many() const { return plane_ || (hull_ && box_->is); }
  void measure_many(double within, NearSamples& near) const;
  const SoftLayer& layer() const { return *layer_; }

 private:
  bool nearest_on_hull(Vec3 x, double within, FramePoint& out) const;
  bool nearest_on_box(Vec3 x, double within, FramePoint& out) const;
  bool nearest_on_mesh(Vec3 x, double within, int triangle, FramePoint& out) const;

  const SoftLayer* layer_ = nullptr;
  const Static* plane_ = nullptr;
  const PosedShape* hull_ = nullptr;
  const FrameBox* box_ = nullptr;
  FrameBox::Way way_;  // of a box
  const triangles::Tree* tree_ = nullptr;
};

}  // namespace hp
