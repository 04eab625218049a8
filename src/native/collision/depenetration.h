// Initial overlaps and how they are resolved (docs/physics.md, "Initial overlaps").
//
// A shape that overlaps a static at the reset, or a part of a person that overlaps an object, is
// not where it is held to be. A displacement w (`exit`, exit_search.h) takes it, and all hulls of
// its group (overlap_groups.h), out on the right side. What contacts keep clear of the obstacle is
// the shape displaced by (1 - s) w, and s (`progress`) only grows: at s = 1 the shape itself is
// clear, and the pair is an ordinary one from then on. Because a step of length zero at the old s
// is always clear, no shape gets deeper, measured along w.
//
// In a substep of length h, s grows so far that no plane of the displaced shape is entered by more
// than `growth` times the depenetration speed times h, less over the last centimetre. A group that
// hardly progresses for some substeps tries another direction, without what is clear by then.
// Limits: displacements are at most 0.6 m long; where none fits, no contact holds the pair until it
// is clear by itself.
#pragma once
#include <utility>
#include <vector>

#include "collision/broad_phase.h"
#include "collision/gap_targets.h"
#include "collision/initial_overlap.h"
#include "collision/exit_search.h"

namespace hp {

class Depenetration {
 public:
  Depenetration(const CollisionWorld& world, GapTargets& targets)
      : world_(world), targets_(targets) {}

  // Pairs that are not clear yet.
  const std::vector<InitialOverlap>& overlaps() const { return overlaps_; }
  bool any() const { return !overlaps_.empty(); }
  InitialOverlap* find(const BroadPhasePair& e);

  // The share of the depenetration speed that the next substep demands.
  double growth = 1;

  void clear();
  // Finds exits for these pairs, which overlap at the poses `start`; each search may cost so many tests
  // (geometry/bvh.h).
  void begin(const Model& m, Poses& start, const std::vector<PairId>& pairs, size_t most_tests);
  // The candidates that hold a pair: planes of the obstacle against the displaced shape, up to
  // `reach`, which is lowered where they hold for less; decides how far the pair comes out in this
  // substep.
  void add_candidates(Poses& start, BroadPhasePair& e, InitialOverlap& in, double& reach, double h,
                      std::vector<ContactCandidate>& out);
  // Groups that are stuck try another direction. True if the pairs have changed.
  bool reroute(const Model& m, Poses& start);
  // The substep has been made, by the trees' shares of it (per body; empty: whole).
  void advance(const std::vector<double>& share);

  // What has been spent since this was last asked.
  size_t take_tests() { return std::exchange(tests_, 0); }

  void save(std::vector<double>& out) const;
  const double* load(const double* in);
  // Takes over the pairs of another simulation: `renamed` gives each its numbers here or says that
  // it is gone, `known` says which of the pairs here the other one knew.
  template <typename Renamed, typename Known>
  void adopt(const Depenetration& old, Renamed renamed, Known known) {
    std::vector<InitialOverlap> in;
    for (InitialOverlap i : old.overlaps_)
      if (renamed(i)) in.push_back(i);
    for (const InitialOverlap& i : overlaps_)
      if (!known(i)) in.push_back(i);
    overlaps_ = in;
    growth = old.growth;
  }

 private:
  Obstacle obstacle(Poses& start, int other_static, int other_shape) const;
  bool any_new(const OverlapGroup& group, const Obstacle& o) const;
  void add_group(Poses& start, const Obstacle& o, const OverlapGroup& group, const Exit& exit);
  double find_planes(const PosedShape& a, const Obstacle& o, BroadPhasePair& e, double range) const;
  void hold_clear(Poses& start, const Obstacle& o, BroadPhasePair& e, InitialOverlap& in,
                  double& reach, double h, std::vector<ContactCandidate>& out);

  const CollisionWorld& world_;
  GapTargets& targets_;
  std::vector<InitialOverlap> overlaps_;
  size_t tests_ = 0;
  Vec3 avoid_;  // unit direction that is not to be tried again; zero: none
};

}  // namespace hp
