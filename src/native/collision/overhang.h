// Objects that stick out over an edge of static geometry.
//
// A candidate's plane has no end; the hull or the triangle that it stands for has. Within the face
// that makes no difference, and a few vertices against a plane are quick. Where an object would
// cross the plane beside the face (a box on the edge of a table, a board on a block), the plane would
// carry what nothing carries. There, as between two moving shapes,
//
// - contacts are the corners of the area where the two faces overlap (corners), and, later, the
//   nearest points at the end pose;
// - the gap at the end is the distance of the shapes themselves (at_end).
//
// A point counts as over the static if that is no farther from it than the plane, up to kOver.
// Lengths in [m].
#pragma once
#include "collision/collision_world.h"
#include "geometry/separation.h"

namespace hp {

class Overhang {
 public:
  explicit Overhang(const CollisionWorld& world) : world_(world) {}

  // Would an object end behind the candidate's plane with a point that was not over the static?
  // Never of a part of a person, whose joints are driven, and of what overlaps.
  bool any(Poses& start, Poses& end, const ContactCandidate& c) const;
  // Of the object from the hull or from the mesh at the end pose. A mesh that is farther than the
  // object's way and the candidate's target gives a lower bound of the distance, and the candidate's
  // normal.
  Separation at_end(Poses& start, Poses& end, const ContactCandidate& c) const;
  static constexpr int kMostCorners = 8;
  // Corners of the area in which the object's face lies over the static, at the start: pairs of
  // points with pa - pb parallel to the candidate's normal.
  int corners(Poses& start, const ContactCandidate& c, Vec3* pa, Vec3* pb) const;

 private:
  bool over(const ContactCandidate& c, Vec3 x) const;

  const CollisionWorld& world_;
};

}  // namespace hp
