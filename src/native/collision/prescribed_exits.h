// Overlaps of people whose poses are prescribed, not simulated (docs/physics.md, "Poses that are
// set").
//
// Such people are moved to a pose in every frame or substep, whatever they overlap there; an object
// that they overlap is pushed out. All hulls of a person that overlap one object and are neighbours
// in the skeleton make a group, and the object leaves the group along one direction: that along
// which the deepest of the group's hulls is least deep, among the normals of the object's faces,
// each pair's own direction of least depth, and the 26 directions of a grid. (Hull by hull the
// directions would work against each other, and an object between two hulls would be thrown.) An
// object between two groups whose directions are opposed is squeezed, and not pushed at all.
#pragma once
#include <vector>

#include "collision/collision_world.h"
#include "collision/pair_states.h"

namespace hp {

class PrescribedExits {
 public:
  PrescribedExits(const CollisionWorld& world, PairStates& states)
      : world_(world), states_(states) {}

  // Per body: the speed at which an object leaves people in the next substep, as a share of the
  // depenetration speed.
  std::vector<double> pace;
  // Per body: objects between two groups that they would have to leave in opposed directions.
  std::vector<char> squeezed;

  // Pace of a candidate's overlap; 1 where poses are simulated.
  double pace_of(const ContactCandidate& c) const {
    if (!world_.forced || !world_.handles(c)) return 1;
    const int object = world_.shapes[c.other_shape].body;
    return squeezed[object] ? 0 : pace[object];
  }
  // People have been moved: drops the states of their pairs.
  void forget();
  // Finds the directions, if people have been moved.
  void update(const Model& m, Poses& start, const std::vector<BroadPhasePair>& pairs);

 private:
  // Two shapes that overlap, and the group that they belong to: its first pair.
  struct Pair {
    int shape, other, group;
  };
  std::vector<Pair> overlaps(Poses& start, const std::vector<BroadPhasePair>& pairs) const;
  void take_group(const Model& m, std::vector<Pair>& all, size_t first,
                  std::vector<size_t>& group) const;
  Vec3 least_deep_direction(Poses& start, const std::vector<Pair>& all,
                            const std::vector<size_t>& group) const;

  const CollisionWorld& world_;
  PairStates& states_;
  bool known_ = true;
};

}  // namespace hp
