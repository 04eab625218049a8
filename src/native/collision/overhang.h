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
#include <cstdint>
#include <utility>
#include <vector>

#include "collision/collision_world.h"
#include "geometry/separation.h"

namespace hp {

class Overhang {
 public:
  explicit Overhang(const CollisionWorld& world) : world_(world) {}
  Overhang(const Overhang&) = delete;

  // Would an object end behind the candidate's plane with a point that was not over the static?
  // Never of a part of a person, whose joints are driven, and of what overlaps.
  bool any(Poses& start, Poses& end, const ContactCandidate& c);
  // Of the object from the hull or from the mesh at the end pose. A mesh that is farther than the
  // object's way and the clearance gives that as a bound of the distance, and the candidate's normal.
  // Where they meet, the distance is -1e300 and nothing else is set.
  Separation at_end(Poses& start, Poses& end, const ContactCandidate& c);
  static constexpr int kMostCorners = 8;
  // Corners of the area in which the object's face lies over the static, at the start: pairs of
  // points with pa - pb parallel to the candidate's normal.
  int corners(Poses& start, const ContactCandidate& c, Vec3* pa, Vec3* pb);

  // What has been spent since this was last asked (geometry/bvh.h).
  size_t take_tests() { return std::exchange(tests_, 0); }

 private:
  // How far a vertex was from a static at the start: more than `farther`, and `nearest` at most.
  struct Known {
    double farther = -1, nearest = 1e300;
  };
  struct StartDistances {
    int shape, other_static;
    std::vector<Known> vertices;
  };
  // Of an object from a mesh at the end pose; nothing is known farther off than `range` [m].
  struct EndDistance {
    int shape, other_static;
    double range;
    Separation nearest;
  };
  const EndDistance& from_mesh(Poses& start, Poses& end, const ContactCandidate& c);
  std::vector<Known>& known(const ContactCandidate& c, const Poses& start, size_t vertices);
  bool over(const ContactCandidate& c, Vec3 x);
  bool over(const ContactCandidate& c, Vec3 x, Known& known);
  double height(const ContactCandidate& c, Vec3 x) const;
  bool within(const ContactCandidate& c, Vec3 x, double distance);

  const CollisionWorld& world_;
  // Of sharp-edged objects: many planes of a mesh ask for the same vertices, in every pass again.
  std::vector<StartDistances> known_;
  size_t tests_ = 0;
  uint64_t known_stamp_ = 0;  // of the start that they hold for
  std::vector<EndDistance> ends_;
  uint64_t ends_stamp_ = 0;  // of the end pose that they hold for
};

}  // namespace hp
