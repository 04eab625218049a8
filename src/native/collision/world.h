// Collision detection, from broad phase to the check of end poses: the components and how they are
// connected.
//
// A substep calls them in this order (docs/physics.md, "The substep"):
//
//     broad_phase.update      which pairs could come near            broad_phase.h
//     narrow_phase.gather     candidates: planes not to be crossed   narrow_phase.h
//       depenetration           ... of initial overlaps              depenetration.h, exit_search.h
//       self_depenetration      ... of a person with itself      self_depenetration.h
//       prescribed_exits        ... of prescribed poses              prescribed_exits.h
//       targets                 gaps that are demanded               gap_targets.h
//     contact_points.add      points of violated candidates          contact_points.h
//     gap_check.excess        does the end pose keep the gaps?       gap_check.h
//     end_check.find          is the pose clear, whatever the above says?   end_check.h
//
// and a frame asks mark_busy_trees() first, which trees need substeps at all (frame_sweep.h).
// `pair_states` remembers pairs that started too near or overlapping. A component sees only those
// that it is constructed with.
#pragma once
#include "collision/broad_phase.h"
#include "collision/clearance_query.h"
#include "collision/collision_world.h"
#include "collision/contact_points.h"
#include "collision/end_check.h"
#include "collision/depenetration.h"
#include "collision/frame_sweep.h"
#include "collision/gap_check.h"
#include "collision/gap_targets.h"
#include "collision/least_overlap.h"
#include "collision/narrow_phase.h"
#include "collision/pair_states.h"
#include "collision/prescribed_exits.h"
#include "collision/self_depenetration.h"
#include "collision/travel_bounds.h"

namespace hp {

class World : public CollisionWorld {
 public:
  World() = default;
  World(const World&) = delete;

  PairStates pair_states;
  PrescribedExits prescribed_exits{*this, pair_states};
  GapTargets targets{*this, pair_states, prescribed_exits};
  BroadPhase broad_phase{*this};
  Depenetration depenetration{*this, targets};
  SelfDepenetration self_depenetration{*this, pair_states};
  PeopleParting parting{*this};
  NarrowPhase narrow_phase{*this,         broad_phase,      pair_states, targets,
                           depenetration, prescribed_exits, parting,     self_depenetration};
  Overhang overhang{*this};
  ContactPoints contact_points{*this, overhang};
  GapCheck gap_check{*this, overhang};
  EndCheck end_check{*this, broad_phase, pair_states, depenetration, parting};

  // No point of a shape travels farther between two poses than `way`, seen from the shape's root
  // body [m]; empty without self-contact.
  void inner_travel(const Model& m, const Poses& from, const Poses& to,
                    std::vector<double>& way) const {
    way.clear();
    if (self_contact()) travel_bounds_in_root_frame(shapes, m, from, to, active, way);
  }

  // Tests of searches (geometry/bvh.h) since this was last asked.
  size_t take_tests() {
    return narrow_phase.take_tests() + depenetration.take_tests() + gap_check.take_tests() +
           overhang.take_tests() + end_check.take_tests();
  }
  // The simulation starts here: remembers the pairs that are nearer than the clearance or overlap,
  // and how the latter are resolved.
  void reset(const Model& m, Poses& start);
  // The state that determines all further steps, as numbers.
  void save(std::vector<double>& out) const;
  const double* load(const double* in);
  // Of pairs that were there before, what was known then: `shape` gives each shape's number in
  // `old` (-1: new).
  void adopt(const World& old, const std::vector<int>& shape);

 private:
  std::vector<PairId> initial_overlaps(Poses& start);
  void remember_pair(const ContactCandidate& c);
};

}  // namespace hp
