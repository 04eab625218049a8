// What a contact demands: the gap at the end of the substep, and the gap under which the step is
// shortened. With d the gap at the start, c the clearance of the pair, h the substep and v the
// depenetration speed (docs/physics.md, "Contact"):
//
//     target = c                              d >= c
//              d + min(c - d, 0.05 m/s h)     0 <= d < c     a clearance that was lost comes back
//              d + min(v h, -d)               d < 0          overlaps are resolved
//              d                              d < 0, hulls overlap where their surfaces are clear
//
// The clearance of a pair is the settings'; a pair that started nearer keeps its own distance until
// it is farther; shapes that come out of an obstacle are held at the least gap. `hard` is half of
// min(d, least gap), so that repeated solving cannot wear a gap away, with floors below which the
// gap may shrink only as slowly as solving is inexact, and then not at all.
#pragma once
#include <vector>

#include "collision/collision_world.h"
#include "collision/prescribed_exits.h"
#include "collision/pair_states.h"

namespace hp {

class GapTargets {
 public:
  GapTargets(const CollisionWorld& world, PairStates& states, const PrescribedExits& forced)
      : world_(world), states_(states), forced_(forced) {}

  // Sets target and hard of a candidate whose dist is known. Forgets the state of a pair that has
  // reached the clearance.
  void set(ContactCandidate& c, double h);
  // Appends the candidate with this plane of the other.
  void add(ContactCandidate& c, const Plane& p, double h, std::vector<ContactCandidate>& out);

 private:
  const CollisionWorld& world_;
  PairStates& states_;
  const PrescribedExits& forced_;
};

}  // namespace hp
