// Two people who start overlapping are taken apart (docs/physics.md, "Initial overlaps").
//
// The lighter one is displaced as a whole, horizontally, along the direction that clears all hulls of
// the two after the shortest way; where something else holds that person back, the other one is, the
// other way. Until all hulls are clear the two pass through each other: hull by hull they would
// interlock. From then on they meet like any two people.
//
// Here is whereto; the velocity is given by stepping/exit_motion.h. Lengths in [m].
#pragma once
#include <cstdint>
#include <vector>

#include "collision/collision_world.h"

namespace hp {

struct Parting {
  int moved = 0, other = 0;        // the two people; the first is displaced
  Vec3 way;                        // unit direction of that
  double left = 0;                 // how far is left, if neither moves otherwise [m]
  int blocked = 0;                 // substeps in a row in which hardly anything came of it
  int shape = 0, other_shape = 0;  // a pair that is not clear
};

class PeopleParting {
 public:
  explicit PeopleParting(const CollisionWorld& world) : world_(world) {}

  const std::vector<Parting>& all() const { return all_; }
  bool any() const { return !all_.empty(); }
  // Do the two shapes pass through each other?
  bool between(int shape, int other_shape) const;
  bool concerns(int person) const;

  void clear() { all_.clear(), stamp_ = 0; }
  // Finds the people who overlap among these pairs of shapes, and their ways.
  void begin(const Model& m, Poses& start, const std::vector<BroadPhasePair>& pairs);
  // Drops those who are apart at this pose.
  void update(Poses& start);
  // In a substep of h [s] the two of all()[k] came `moved` [m] apart, of `asked`.
  void advance(size_t k, double moved, double asked);

  void save(std::vector<double>& out) const;
  const double* load(const double* in);
  void adopt(const PeopleParting& old, const std::vector<int>& shape_now);

 private:
  bool blocks(Poses& start, int shape, int other_shape, Vec3 shift, double& depth) const;
  bool clear(Poses& start, Parting& p, Vec3 shift, double& depth) const;
  void find_way(Poses& start, Parting& p) const;

  const CollisionWorld& world_;
  std::vector<Parting> all_;
  uint64_t stamp_ = 0;  // of the pose that they are known at
};

}  // namespace hp
