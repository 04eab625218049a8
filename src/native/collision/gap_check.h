// Does the end pose keep the gap that a candidate demands, and where not, does the shape meet
// anything?
//
// The gap at the end is measured along the candidate's plane; of two shapes whose nearest features
// have stayed the same, and of an object that sticks out over an edge (overhang.h), it is their true
// distance at the end, because the plane turns as they do. A
// plane that is crossed is *forgiven* if the shape meets nothing behind it: if the swept hull (the
// hull of the shape's start and end vertices, seen from the other) is disjoint from the other by
// the clearance and by the bulge. The bulge is how far the paths of points stray out of the swept
// hull, on the arcs of all joints that move them (path_bounds.h), as the other one sees them. There
// are no ghost contacts at edges that a shape passes by.
#pragma once
#include <cstdint>
#include <utility>
#include <vector>

#include "collision/collision_world.h"
#include "collision/overhang.h"
#include "collision/path_bounds.h"

namespace hp {

class GapCheck {
 public:
  GapCheck(const CollisionWorld& world, Overhang& overhang) : world_(world), overhang_(overhang) {}

  // Smallest gap of a candidate at the end pose minus its target [m]; kForgiven, and c.forgiven is
  // set, where the plane is crossed but nothing is behind it. What the candidate's plane shows to miss
  // its target by no more than `slack` [m] is not looked at closer: the plane's gap is told then.
  double excess(const Model& m, Poses& start, Poses& end, ContactCandidate& c, double slack);
  static constexpr double kForgiven = 1e300;
  // The same of a triangle's plane that may not be crossed.
  double unforgiven(Poses& end, ContactCandidate& c) const;
  // Is the swept hull clear of the candidate's whole mesh? Then no plane of it that may be crossed
  // hides anything. Computed once per pair and end pose.
  bool mesh_clear(const Model& m, const ContactCandidate& c, Poses& start, Poses& end);

  // What has been spent since this was last asked (geometry/bvh.h).
  size_t take_tests() { return std::exchange(tests_, 0); }

 private:
  const PathBounds& paths(const Model& m, const Poses& start, const Poses& end);
  double bulge(const Model& m, const ContactCandidate& c, Poses& start, Poses& end, double chord);
  bool vertex_meets(const ContactCandidate& c, Poses& end) const;
  bool swept_clear(const Model& m, const ContactCandidate& c, Poses& start, Poses& end);
  bool swept_mesh_clear(const Model& m, const ContactCandidate& c, Poses& start, Poses& end);

  const CollisionWorld& world_;
  Overhang& overhang_;
  size_t tests_ = 0;
  struct MeshAnswer {
    int shape, other_static;
    bool clear;
  };
  std::vector<MeshAnswer> answers_;
  uint64_t answers_stamp_ = 0;  // of the end pose that they hold for
  PathBounds paths_;
  uint64_t paths_stamp_ = 0;  // of the end pose that they lead to
};

}  // namespace hp
