// What there is to collide: shapes that bodies carry, static geometry, and what holds between
// pairs.
//
// Plain data, filled in once by the caller; only which trees take part in a step (`active`,
// `standing`, `asleep`) changes later. Every component of collision detection reads it and none
// writes to it. Lengths in [m], times in [s].
#pragma once
#include <memory>
#include <vector>

#include "collision/collision_shape.h"
#include "collision/contact_candidate.h"
#include "collision/poses.h"
#include "dynamics/kinematic_tree.h"
#include "geometry/bvh.h"
#include "geometry/convex.h"

namespace hp {

// Static geometry: a half-space, a convex hull, or any soup of triangles.
struct Static {
  enum class Kind { HalfSpace, Hull, Mesh } kind = Kind::HalfSpace;
  int name = 0;  // index into the names of material pairs
  Vec3 n;        // the half-space is n.x <= offset
  double offset = 0;
  Convex hull;       // in the world frame
  PosedShape posed;  // of `hull`
  std::shared_ptr<const TriangleTree> tree;
  double layer = 0;  // thickness of the soft layer above it [m]; 0: it is hard
};

// Material properties of two names.
struct Pairing {
  double friction = 0, restitution = 0;
  bool ignore = false;  // the two never touch
};

struct ContactSettings {
  double clearance = 1e-3;           // smallest gap that contacts keep [m]
  double depenetration_speed = 0.5;  // at which overlaps are resolved [m/s]
  double tolerance = 1e-6;           // of the solver, per substep [m]
  int max_sweeps = 50;
};

struct CollisionWorld {
  std::vector<CollisionShape> shapes;
  std::vector<Static> statics;
  std::vector<Pairing> pairings;  // names x names
  int n_names = 0;
  ContactSettings settings;
  // Per body: its tree takes part in the step; pairs of the others are left out.
  std::vector<char> active;
  // Per body: its tree has made its step already, and is an obstacle to those that take part.
  std::vector<char> standing;
  // Per body: its tree rests where it is until something touches it, and meets no static geometry.
  std::vector<char> asleep;
  // People's poses are set, not simulated: static geometry does not stop them, and what they
  // overlap is found anew in every step (prescribed_exits.h).
  bool forced = false;

  const Pairing& pairing(int a, int b) const { return pairings[a * n_names + b]; }

  // Self-collision: the pairs of shapes of one tree that may touch each other.
  void set_self_pairs(const std::vector<std::pair<int, int>>& pairs);
  bool self_contact() const { return !self_pairs_.empty(); }
  bool may_touch_itself(int a, int b) const {
    return !self_pairs_.empty() && self_pairs_[a * shapes.size() + b];
  }

  bool may_touch(const Model& m, int a, int b) const;
  bool takes_part(const BroadPhasePair& e) const;
  // Whether a person meets an object or another person.
  bool handles(const ContactCandidate& c) const {
    return c.other_shape >= 0 && (shapes[c.shape].person >= 0 || shapes[c.other_shape].person >= 0);
  }
  // Two shapes of one person that overlap at the start of the substep.
  bool overlaps_itself(const ContactCandidate& c) const {
    return c.dist < 0 && c.other_shape >= 0 && may_touch_itself(c.shape, c.other_shape);
  }

  // The kinematics of `p` are those of a new pose; and a shape there.
  void start_poses(Poses& p) const { p.restart(shapes.size()); }
  const PosedShape& place(Poses& p, int shape) const { return p.at(shapes, shape); }

 private:
  std::vector<char> self_pairs_;  // shapes x shapes; empty: none
};

}  // namespace hp
