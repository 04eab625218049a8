// Overlaps of a person with itself, and the directions in which they are resolved (docs/physics.md,
// "Self-contact").
//
// A pair of hulls of one person that overlaps at the start leaves along a fixed direction
// (PairState:: exit). Pairs whose bodies are neighbours in the skeleton on both sides share one
// direction: a hand whose fingers left in front of an arm while its palm left behind it would never
// get out. The shared direction is that along which the deepest pair of the group is least deep
// (least_overlap.h). If the depth summed over all pairs has not fallen enough after some substeps,
// directions are chosen anew.
#pragma once
#include <vector>

#include "collision/collision_world.h"
#include "collision/pair_states.h"

namespace hp {

class SelfDepenetration {
 public:
  SelfDepenetration(const CollisionWorld& world, PairStates& states)
      : world_(world), states_(states) {}

  // Of two bodies of one person the one that carries more mass: the pair's exit turns with it.
  // `c`: anything that names a pair.
  template <typename AnyPair>
  int reference_body(const Model& m, const AnyPair& c) const {
    const int a = world_.shapes[c.shape].body, b = world_.shapes[c.other_shape].body;
    return m.carried[a] > m.carried[b] ? a : b;
  }
  // The simulation starts: chooses directions.
  void reset(const Model& m, Poses& start);
  // A substep begins: chooses directions anew where too little progress was made.
  void update(const Model& m, Poses& start);

  void save(std::vector<double>& out) const;
  const double* load(const double* in);

 private:
  struct Pair {
    PairState* state;
    int shape, other, reference, group;
    double sign;  // of the shared direction
  };
  void choose_directions(const Model& m, Poses& start);
  std::vector<Pair> overlapping(const Model& m);
  std::vector<size_t> take_group(const Model& m, std::vector<Pair>& all, size_t first) const;

  const CollisionWorld& world_;
  PairStates& states_;
  int waited_ = 0;        // substeps since progress was last measured
  double depth_ = 1e300;  // sum of depths along the exits then [m]
};

}  // namespace hp
