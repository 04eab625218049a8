// Collision detection, from broad phase to the check of end poses: the components and how they are connected.
//
// A substep calls them in this order (docs/physics.md, "The substep"):
//
//     broad_phase.update      which pairs could come near            broad_phase.h
//     narrow_phase.gather     candidates: planes not to be crossed   narrow_phase.h
//       depenetration           ... of initial overlaps              depenetration.h, exit_search.h
//       self_depenetration      ... of a person with themselves      self_depenetration.h
//       prescribed_exits        ... of prescribed poses              prescribed_exits.h
//       targets                 gaps that are demanded               gap_targets.h
//     contact_points.add      points of violated candidates          contact_points.h
//     gap_check.excess        does the end pose keep the gaps?       gap_check.h
//
// and a frame asks mark_busy_trees() first, which trees need substeps at all (frame_sweep.h).
// `pair_states` remembers pairs that started too near or overlapping. A component sees only those that
// it is constructed with.
#pragma once
#include "collision/broad_phase.h"
#include "collision/clearance_query.h"
#include "collision/collision_world.h"
#include "collision/contact_points.h"
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
#include "tuning.h"

namespace hp {

using tuning::collision::kLeastGap;

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
  NarrowPhase narrow_phase{*this,   broad_phase,   pair_states,  targets,
                           depenetration, prescribed_exits, self_depenetration};
  ContactPoints contact_points{*this};
  GapCheck gap_check{*this};

  // What stepping calls, until it calls the components themselves.
  std::vector<double>& pace = prescribed_exits.pace;
  std::vector<char>& squeezed = prescribed_exits.squeezed;
  double& growth = depenetration.growth;
  void people_put() { prescribed_exits.forget(); }
  void forget() { broad_phase.forget(); }
  void travel(const std::vector<double>& way, const std::vector<double>& inner) {
    broad_phase.travel(way, inner);
  }
  void list(const Model& m, const Poses& p, const std::vector<double>& reach) {
    broad_phase.update(m, p, reach, depenetration.inside());
  }
  void find_busy(const Model& m, Poses& start, Poses& end, const Sweep& sweep, std::vector<char>& busy) {
    mark_busy_trees(*this, broad_phase, depenetration.inside(), m, start, end, sweep, busy);
  }
  double travelled(int shape) const { return broad_phase.travelled(shape); }
  void choose_again(const Model& m, Poses& start) { self_depenetration.update(m, start); }
  double gap(Poses& p, int a, int b) const { return pair_gap(*this, p, a, b); }
  void inner_ways(const Model& m, const Poses& from, const Poses& to, std::vector<double>& way) const {
    way.clear();
    if (self_contact()) travel_bounds_in_root_frame(shapes, m, from, to, active, way);
  }
  const std::vector<Inside>& inside() const { return depenetration.inside(); }
  bool any_inside() const { return depenetration.any(); }
  void reroute(const Model& m, Poses& start) {
    if (depenetration.reroute(m, start)) broad_phase.invalidate();
  }
  void come_out(const std::vector<double>& share) { depenetration.advance(share); }
  void gather(const Model& m, Poses& start, const std::vector<double>& reach, double h,
              std::vector<ContactCandidate>& out) {
    narrow_phase.gather(m, start, reach, h, out);
  }
  double excess(Poses& start, Poses& end, ContactCandidate& c) const {
    return gap_check.excess(start, end, c);
  }
  bool mesh_clear(const ContactCandidate& c, Poses& start, Poses& end) {
    return gap_check.mesh_clear(c, start, end);
  }
  void search_behind(Poses& start, const std::vector<double>& reach, double h, int index,
                     std::vector<ContactCandidate>& all) {
    narrow_phase.search_behind(start, reach, h, index, all);
  }
  void add_contacts(const std::vector<CachedContact>& cached, Poses& start, Poses& end,
                    const ContactCandidate& c, int index, int pass, std::vector<Contact>& contacts) const {
    contact_points.add(cached, start, end, c, index, pass, contacts);
  }
  bool recall(const std::vector<CachedContact>& cached, const std::vector<ContactCandidate>& candidates,
              std::vector<char>& out) const {
    return contact_points.recall(cached, candidates, out);
  }
  double gap_at(Poses& start, Poses& end, const Contact& c) const {
    return contact_points.gap_at(start, end, c);
  }
  double clearance(const Model&, Poses& p, double range) const {
    return smallest_clearance(*this, broad_phase, p, range);
  }
  void clearances(Poses& p, double range, double* dist, int* nearest) const {
    shape_clearances(*this, p, range, dist, nearest);
  }

  // The simulation starts here: remembers the pairs that are nearer than the clearance or overlap, and
  // how the latter are resolved.
  void reset(const Model& m, Poses& start);
  // The state that determines all further steps, as numbers.
  void save(std::vector<double>& out) const;
  const double* load(const double* in);
  // Of pairs that were there before, what was known then: `shape` gives each shape's number in `old`
  // (-1: new).
  void adopt(const World& old, const std::vector<int>& shape);

 private:
  std::vector<Depenetration::Overlap> overlaps(Poses& start);
  void remember_pair(const Model& m, const ContactCandidate& c);
};

}  // namespace hp
