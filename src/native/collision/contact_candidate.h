// The records that pass from one phase of collision detection to the next.
//
// Broad phase: BroadPhasePair, two shapes whose distance is worth tracking. Narrow phase:
// ContactCandidate, a separating plane that the substep must not cross. Contact generation: Contact
// (contact/solver.h). From substep to substep: CachedContact. Lengths in [m].
//
// In all of them a pair is a shape (`shape`) and either a static (`other_static`) or a second shape
// (`other_shape`); the one that is not meant is -1.
#pragma once
#include <cstdint>
#include <functional>
#include <vector>

#include "contact/solver.h"
#include "geometry/bvh.h"
#include "geometry/convex.h"
#include "geometry/gjk.h"

namespace hp {

// A pair alone.
struct PairId {
  int shape = 0, other_static = -1, other_shape = -1;
};

// A pair that may come near, and what is known of its distance: at least `dist` minus what the two
// have travelled since, or, up to `planes_reach`, as far as the planes say. It only saves work:
// what is skipped for it could not have been a candidate.
struct BroadPhasePair {
  static constexpr double kUnknown = -1e300;    // of `dist`
  static constexpr double kEverywhere = 1e300;  // as a range

  int shape = 0;
  int other_static = -1, other_shape = -1;
  bool own = false;        // two of one person: distances are travelled in the root's frame
  double dist = kUnknown;  // lower bound when last measured [m]
  double travelled = 0;    // what the two had travelled by then [m]
  // All geometry of the other within `planes_reach` of the shape lies behind these planes.
  std::vector<Plane> planes;
  double planes_reach = 0;
  Vec3 axis;           // direction between the nearest points when last measured; 0: not yet
  Hint hint;           // where that search ended
  uint64_t query = 0;  // the last one that it took part in (last_candidates.h)
  // Of the end check (end_check.h): a lower bound of the distance, what the two had travelled when
  // it was proved, and directions that separate them.
  double room = 0, room_at = 0;
  SeparatingAxes axes;
};

// What is known of a candidate: its plane, or only that the two are no nearer than `dist`, by a direction
// that separates them or by how far they have travelled since they were measured. What does not get that
// far in the step needs no plane (narrow_phase.h).
enum class Known : char { Plane, Direction, Travel };

// A pair of shapes that may meet in this substep, and the plane that is to keep them apart.
struct ContactCandidate {
  Known known = Known::Plane;
  int shape = 0;
  int other_static = -1, other_shape = -1;
  Vec3 n;                 // unit, from the other to the shape
  double offset = 0;      // static: the other lies in n.x <= offset
  double dist = 0;        // at the start of the substep; negative: overlap along n [m]
  double target = 0;      // distance demanded at its end [m]
  double hard = 0;        // distance under which the step is shortened [m]
  int triangle = -1;      // of a mesh
  Hint hint;              // of two shapes at the start
  Vec3 pa, pb;            // of two shapes that are apart: their nearest points at the start
  bool forgiven = false;  // the plane may be crossed: the shape meets nothing behind it
  bool searched = false;  // candidates that its plane had hidden have been added
  // A shape that overlapped at the start of the simulation is held clear where it would be after a
  // displacement (depenetration.h): `from` at the start of the substep and, where the step makes
  // `share` of it, that share of the way from there to `to` at its end.
  int overlap = -1;  // index into Depenetration::overlaps(); -1: an ordinary candidate
  int soft = -1;     // a pair that presses a soft layer (stepping/soft_contacts.h); -1: a plane
  int island = 0;    // what it is settled with (stepping/islands.h)
  Vec3 from, to;
  double share = 1;
  Vec3 shift() const { return from + share * (to - from); }
};

// A contact point that carried an impulse in the substep before.
struct CachedContact {
  int64_t key;  // of the pair
  int feature;
  Material point, other;  // on the shape; on the other shape: the point opposite
  Vec3 normal, impulse;   // in the world
  double spread;          // of its patch (friction_places.h); 0: not known
  bool used;
  int candidate = -1;  // of this attempt, for which it is recalled; -1: none
};

struct Poses;

// Bounds for the shapes on their way from one pose to another, without contact; per shape [m].
struct Sweep {
  std::vector<double> travel;    // no point of the shape goes farther
  std::vector<double> straight;  // the part of `travel` that follows from the two poses alone
  std::vector<double> bulge;     // no point strays farther from the straight line between its ends
  std::vector<double> inner;     // `straight` as seen from the root; empty without self-contact
  // Poses at 1, 2, ... of kPathParts parts of the way, made when they are asked for; empty: none.
  std::function<std::vector<Poses>&()> between;
};

// The identity of a pair as a number, in the order of shapes, and back.
template <typename Pair>
int64_t pair_key(const Pair& c) {
  return ((int64_t)c.shape << 32) |
         (int64_t)(c.other_static >= 0 ? 2 * c.other_static : 2 * c.other_shape + 1);
}
inline PairId pair_of_key(int64_t key) {
  PairId p;
  p.shape = (int)(key >> 32);
  const int other = (int)(key & 0xffffffff);
  (other % 2 == 0 ? p.other_static : p.other_shape) = other / 2;
  return p;
}

}  // namespace hp
