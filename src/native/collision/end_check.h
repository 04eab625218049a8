// The end check: does the pose that a step would commit have an overlap that its start did not have?
//
// It does not look at candidates, planes or what the solver believes. Of every listed pair that
// takes part and can have come into contact it asks both shapes themselves: is there a direction
// that separates them? (Of two hulls of one person it asks their bounding spheres at that pose first.)
// Directions are remembered per pair, but only what they prove at the pose
// counts: that of the end, or that of the start, less what the step takes the two, which needs no vertex
// posed anew. `room`, a lower bound of the distance that was proved at a committed pose, less what the
// two have travelled since, says for most pairs that there is nothing to ask.
//
// A step that it refuses is shortened (sub_stepping.h); what cannot be avoided is reported as a
// breach. Not looked at: overlaps that are being resolved, and what a person's prescribed pose
// meets. Lengths in [m].
#pragma once
#include <utility>
#include <vector>

#include "collision/broad_phase.h"
#include "collision/depenetration.h"
#include "collision/pair_states.h"
#include "collision/people_parting.h"

namespace hp {

// Two shapes, or a shape and a static, that overlap although they were clear, or deeper than before.
struct Breach {
  PairId pair;
  double depth = 0;
};

class EndCheck {
 public:
  EndCheck(const CollisionWorld& world, BroadPhase& broad_phase, PairStates& states,
           Depenetration& depenetration, const PeopleParting& parting)
      : world_(world),
        broad_phase_(broad_phase),
        states_(states),
        depenetration_(depenetration),
        parting_(parting) {}

  // Indices, in the broad phase's list, of pairs that breach the end of a step, on which no shape travels
  // farther than `way`, seen from its root `inner` (empty without self-contact). Once per end pose.
  const std::vector<size_t>& find(Poses& start, Poses& end, const std::vector<double>& way,
                                  const std::vector<double>& inner);
  // Is such a pair breached at another end, too?
  bool breached_at(Poses& start, Poses& end, size_t pair);
  // What has been spent since this was last asked (geometry/bvh.h).
  size_t take_tests() { return std::exchange(tests_, 0); }
  // The end that was looked at last is the pose from now on, and the broad phase knows. Returns what is
  // breached there: the depth along the normal of a triangle, by which find() refuses a step, may be that of
  // a touch, and a touch is none.
  std::vector<Breach> commit(Poses& end);

 private:
  double gap(Poses& p, const BroadPhasePair& e, SeparatingAxes& axes, bool least = false);
  double room_at(Poses& start, const BroadPhasePair& e) const;
  bool exempt(const BroadPhasePair& e) const;
  bool breached(Poses& start, Poses& end, const BroadPhasePair& e, double gap);

  const CollisionWorld& world_;
  BroadPhase& broad_phase_;
  PairStates& states_;
  Depenetration& depenetration_;
  const PeopleParting& parting_;
  std::vector<size_t> breached_;  // indices into the list
  struct Measured {
    size_t pair;  // index into the list
    double room;
  };
  std::vector<Measured> measured_;
  size_t tests_ = 0;
  uint64_t stamp_ = 0;  // of the end pose that `breached_` and `measured_` are of
};

}  // namespace hp
