// Contact generation: where the pair of a violated candidate touches, as points with a gap each.
//
// A candidate is a plane; the solver needs points. Which, depends on the pair:
//
// - *against a static*: of a person, first the vertices that carried an impulse in the substep
//   before; then those that would end deepest, at first spread out (so that few points carry a
//   face), at most four more per pass;
// - *an object beside the edge of a static* (overhang.h): the corners of the area where the two
//   faces overlap; then the nearest points at the end pose;
// - *a disc against a static*: points of its rim in a direction of the world, not of the material,
//   so that what rolls or tips is measured where it touches: the deepest, and four that make it
//   stand;
// - *two moving shapes, first pass*: the points that carried an impulse in the substep before, the
//   corners of the area where two near faces overlap (face_manifold), each with its own gap so that
//   what is slanted can settle, and the nearest points;
// - *two moving shapes, later passes*: the nearest points at the end pose, along the normal there;
//   where that does not settle, along the start's normal, because whatever is apart along any
//   direction is apart;
// - *a shape that still overlaps an object initially*: the nearest points of the displaced shape.
//
// Each contact has a normal n, points a and b with the bodies that carry them, and a gap
//
//     gap(end) = dist - closing + n.(displacement of a - displacement of b),
//
// measured exactly at the end pose by gap_at() and linearly by the solver. Contacts of overlapping
// pairs that leave each other have no friction. Lengths in [m].
#pragma once
#include <vector>

#include "collision/collision_world.h"
#include "collision/overhang.h"

namespace hp {

class ContactPoints {
 public:
  ContactPoints(const CollisionWorld& world, Overhang& overhang)
      : world_(world), overhang_(overhang) {}

  // Adds contact points of a violated candidate (number `index`), or better ones than in the passes
  // before; `cached` are those of the substep before.
  void add(const std::vector<CachedContact>& cached, Poses& start, Poses& end,
           const ContactCandidate& c, int index, int pass, std::vector<Contact>& contacts) const;
  // Is a candidate one of those whose contacts are recalled: a person's, not by the rim of a disc?
  // (Contacts between objects are not: points between two that nothing presses together would give
  // a pile energy.)
  bool recalls(const ContactCandidate& c) const;
  // Gives cached contacts the candidate that they belong to: of several planes of a pair the one
  // that is most like their own. Points that carried no impulse count as long as they are near.
  // True if there are any.
  bool recall(Poses& start, const std::vector<ContactCandidate>& candidates,
              std::vector<CachedContact>& cached) const;
  // The gap of a contact's own points at the end pose [m].
  double gap_at(Poses& start, Poses& end, const Contact& c) const;

 private:
  bool stays(Poses& start, const ContactCandidate& c, const CachedContact& w) const;
  double rim_gap_at(Poses& start, Poses& end, const Contact& c, int shape) const;

  const CollisionWorld& world_;
  Overhang& overhang_;
};

}  // namespace hp
