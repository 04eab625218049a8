// Where the samples of a shape are at a pose, and how they face.
//
// Of a skin whose shape has not been posed only the samples that are asked for are, as Poses would, to the
// last bit.
#pragma once
#include "collision/poses.h"
#include "soft/near_samples.h"
#include "soft/soft_world.h"

namespace hp {

class SamplePoses {
 public:
  SamplePoses(const CollisionWorld& world, const SoftWorld& soft, Poses& pose, int shape);
  Vec3 position(int sample) const;
  // Hard points of all, and outward normals.
  void put_points(NearSamples& near) const;
  void put_normals(NearSamples& near) const;
  // Are normals to be found anew at every pose? Those of a skin hardly turn in a step.
  bool turns() const { return !shape_.skin; }

  // How a body carries points of the skin at rest: R x + shift, in columns.
  struct Carrying {
    double column[3][4], shift[4];
  };

 private:
  static constexpr int kMostInfluences = 24;  // of shapes that are posed sample by sample

  Vec3 normal(int sample) const;

  const SurfaceSamples& samples_;
  const CollisionShape& shape_;
  const Poses& pose_;
  Points points_{};                     // of a skin that has been posed
  Carrying carrying_[kMostInfluences];  // of a skin
};

}  // namespace hp
