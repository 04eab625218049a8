// Narrow phase: contact candidates, the separating planes that the next substep must not cross.
//
// For every listed pair within reach at the start of the substep:
//
// - half-space: its own plane;
// - two convex shapes (an object, a part, a hull of a static): the plane across the line between
//   their nearest points, by GJK (geometry/convex.h). Where they overlap, the direction is fixed
//   when the overlap is first seen, in the world or, of two shapes of one person, in the frame of
//   the heavier one, so that the pair leaves steadily;
// - mesh: planes to triangles, nearest first, without the triangles behind a plane already found
//   (geometry/bvh.h). A mesh triangle that a shape overlaps gives no plane: overlaps are resolved by
//   depenetration.h. None arises by a step, but a host, or an edit of the scene, may make one: it is
//   then held and resolved like those at the start.
//
// Most pairs of a person within reach do not get near each other in the step. Of those that are kWaitingGap beyond the
// clearance by a bound the plane is not sought at once: by what they have travelled since they were
// measured (nothing is posed), or by the direction that separated them last. Their candidate is the bound
// alone; it is refined where the step takes them that far.
//
// Planes are valid for displacements up to the reach they were asked for, or less where a mesh has
// too many of them: `valid` is lowered to that, per shape. What each candidate demands of its gap is
// set by gap_targets.h. Lengths in [m], times in [s].
#pragma once
#include <utility>
#include <vector>

#include "collision/broad_phase.h"
#include "collision/depenetration.h"
#include "collision/prescribed_exits.h"
#include "collision/gap_targets.h"
#include "collision/last_candidates.h"
#include "collision/pair_states.h"
#include "collision/people_parting.h"
#include "collision/self_depenetration.h"

namespace hp {

class NarrowPhase {
 public:
  NarrowPhase(const CollisionWorld& world, BroadPhase& broad_phase, PairStates& states,
              GapTargets& targets, Depenetration& depenetration, PrescribedExits& forced,
              PeopleParting& parting, const SelfDepenetration& self)
      : world_(world),
        broad_phase_(broad_phase),
        states_(states),
        targets_(targets),
        depenetration_(depenetration),
        forced_(forced),
        parting_(parting),
        self_(self) {}

  // The candidates of all listed pairs within `valid[shape]` of each other, for a substep of h.
  // Lowers `valid` where they hold for less. Asked again at the same pose, pairs of shapes for which
  // `valid` is the same have the same candidates (last_candidates.h).
  void gather(const Model& m, Poses& start, std::vector<double>& valid, double h,
              std::vector<ContactCandidate>& out);
  // A substep begins: all pairs are to be measured.
  void begin_substep() { last_.forget(); }
  // A better bound of a candidate that has no plane yet, or its plane: of all[index].
  void refine(const Model& m, Poses& start, double h, int index,
              std::vector<ContactCandidate>& all);
  // Planes of a mesh that may be crossed hide nothing: appends the candidates behind those of the pair
  // of all[index] that are marked as searched.
  void search_behind(Poses& start, std::vector<double>& valid, double h, int index,
                     std::vector<ContactCandidate>& all);
  // Tests against planes that searches in meshes have made since this was last asked.
  size_t take_tests() { return std::exchange(tests_, 0); }

 private:
  // Of one pair.
  void measure(const Model& m, Poses& start, BroadPhasePair& e, std::vector<double>& valid,
               double h, std::vector<ContactCandidate>& out);
  // Of one pair, within a distance of r; `c` names the pair.
  void add_half_space(const PosedShape& a, BroadPhasePair& e, ContactCandidate& c, double r,
                      double h, std::vector<ContactCandidate>& out);
  bool add_bound(BroadPhasePair& e, ContactCandidate& c, Known by, double bound, double r, double h,
                 std::vector<ContactCandidate>& out);
  double bound_along(Poses& start, const BroadPhasePair& e) const;
  void add_shapes(const Model& m, Poses& start, BroadPhasePair& e, ContactCandidate& c, double r,
                  double h, std::vector<ContactCandidate>& out);
  void measure_shapes(const Model& m, Poses& start, BroadPhasePair& e, ContactCandidate& c,
                      double r, double h, std::vector<ContactCandidate>& out);
  void add_hull(const PosedShape& a, const BroadPhasePair& e, ContactCandidate& c, double h,
                std::vector<ContactCandidate>& out);
  void add_static(const Model& m, Poses& start, const PosedShape& a, BroadPhasePair& e,
                  ContactCandidate& c, double& valid, double h, std::vector<ContactCandidate>& out);
  void resolve(const Model& m, Poses& start, BroadPhasePair& e, double& valid, double h,
               std::vector<ContactCandidate>& out);
  void fix_exit(const PosedShape& a, const PosedShape& b, const Mat3& frame, ContactCandidate& c);

  const CollisionWorld& world_;
  BroadPhase& broad_phase_;
  PairStates& states_;
  GapTargets& targets_;
  Depenetration& depenetration_;
  PrescribedExits& forced_;
  PeopleParting& parting_;
  const SelfDepenetration& self_;
  LastCandidates last_;
  std::vector<ContactCandidate> refined_;  // scratch
  size_t tests_ = 0;
};

}  // namespace hp
