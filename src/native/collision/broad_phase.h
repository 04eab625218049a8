// Broad phase: which pairs could come near at all, and a lower bound of each pair's distance.
//
// *The list.* All pairs within reach of each other are listed with a margin, by boxes around
// bounding spheres. It holds as long as no shape has travelled farther than the list allowed for;
// then it is made anew, and pairs that stay keep what is known of them.
//
// *Bounds.* Each pair remembers its distance when it was last measured and what the two had
// travelled by then. With D what they have travelled since (travel_bounds.h), the distance is at
// least
//
//     dist - D,
//
// and a pair is skipped while that exceeds the reach of the query. A pair with a static keeps the
// separating planes too: a shape on the outer side of all planes is clear, if they were computed
// for as far as it can reach. Two shapes of one person count what they travel in the root's frame.
//
// Bounds save measurements and decide no result. The saved state includes them all the same: which
// of several equally near points a search finds first depends on them. Lengths in [m].
#pragma once
#include <vector>

#include "collision/collision_world.h"
#include "collision/initial_overlap.h"

namespace hp {

class BroadPhase {
 public:
  explicit BroadPhase(const CollisionWorld& world) : world_(world) {}

  // All shapes have been moved: drops the list and all distances.
  void forget();
  // The list is to be made anew; what is known of its pairs stays.
  void invalidate() { listed_once_ = false; }
  // Shapes of active trees have moved, no farther than `travel` each; seen from their roots no
  // farther than `inner`, which is empty without self-contact.
  void travel(const std::vector<double>& travel, const std::vector<double>& inner);
  double travelled(int shape) const { return travelled_[shape]; }
  // What the two shapes of a pair have.
  double travelled(const BroadPhasePair& e) const {
    if (e.own) return inner_[e.shape] + inner_[e.other_shape];
    return travelled_[e.shape] + (e.other_shape >= 0 ? travelled_[e.other_shape] : 0.0);
  }
  // Lists all pairs that can come within `reach[shape]` of each other, unless the list says so
  // already. Overlaps that are being resolved (`overlaps`) are listed wherever they are.
  void update(const Model& m, const Poses& p, const std::vector<double>& reach,
              const std::vector<InitialOverlap>& overlaps);
  // Does the list hold every pair of a person's shape and a static within `range` [m]?
  bool covers_people(double range) const;

  std::vector<BroadPhasePair>& pairs() { return pairs_; }
  const std::vector<BroadPhasePair>& pairs() const { return pairs_; }
  // The pair of a candidate, which is listed.
  BroadPhasePair& pair_of(const ContactCandidate& c);

  // Is the pair farther apart than r by its bound? By its planes, the shape being at `a`? By the
  // bounding spheres of two shapes (which improves the bound)?
  bool far(const BroadPhasePair& e, double r) const { return bound(e) > r; }
  double bound(const BroadPhasePair& e) const { return e.dist - (travelled(e) - e.travelled); }
  bool behind_planes(const BroadPhasePair& e, const PosedShape& a, double r) const;
  bool spheres_apart(Poses& p, BroadPhasePair& e, double r) const;
  // Were the pair's planes computed for everything within r?
  bool planes_reach(const BroadPhasePair& e, double r) const {
    return !e.planes.empty() && travelled(e) - e.travelled + r <= e.planes_reach;
  }
  // The pair has been measured: its distance is `dist` or more now.
  void measured(BroadPhasePair& e, double dist) const {
    e.dist = dist;
    e.travelled = travelled(e);
  }
  // Measures a pair of a shape and a static up to a distance of r: dist, planes, axis and hint. What
  // a search in a mesh costs is added to `tests` (geometry/bvh.h).
  void measure_static(Poses& p, BroadPhasePair& e, double r, size_t* tests = nullptr) const;

  // The state, in two parts (the self-contact state lies between them).
  void save_travel(std::vector<double>& out) const;
  const double* load_travel(const double* in);
  void save_pairs(std::vector<double>& out) const;
  const double* load_pairs(const double* in);

 private:
  struct Bounds;
  Bounds bounds(const Model& m, const Poses& p) const;
  void list_statics(const Model& m, const Bounds& b, int shape,
                    const std::vector<InitialOverlap>& overlaps);
  void list_shapes(const Model& m, const Bounds& b, int shape);
  void add(int shape, int other_static, int other_shape, bool own);

  const CollisionWorld& world_;
  std::vector<BroadPhasePair> pairs_;  // by shape, then statics, then other shapes
  bool listed_once_ = false;           // pairs_ holds for the distances below
  // Per shape: what it has travelled; what it had when the list was made; how far it may since.
  std::vector<double> travelled_, listed_, range_;
  std::vector<double> inner_;  // per shape: what it has travelled in its root's frame
  // While the list is made: the list before, and its first pair that has not been taken over.
  std::vector<BroadPhasePair> old_;
  size_t next_old_ = 0;
};

}  // namespace hp
