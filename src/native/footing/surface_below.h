// The surface below a point: what somebody who stands there stands on.
//
// A vertical line from above the point down. Static geometry counts up to `step` above it (a stair
// that a foot has sunk into), objects only where they are under it: what a foot kicks is no ground.
// Walls and steep slopes are none either. Of what has a soft layer it is the frame, with the layer above it.
#pragma once
#include <vector>

#include "collision/collision_world.h"

namespace hp {

struct Surface {
  double height = 0;                             // of the surface [m]
  int shape = -1;                                // the object's shape, -1: static geometry
  double layer = 0;                              // of softness above it, along the vertical [m]
  double top() const { return height + layer; }  // without load [m]
  bool found = false;
};

class SurfaceBelow {
 public:
  // `own`: bodies of the person who stands, and what it holds, are no ground (one for each of the model's), nor is
  // what all of it passes through; nullptr: everything is but people.
  explicit SurfaceBelow(const CollisionWorld& world, const char* own = nullptr);
  // The highest surface under `x`, at most `depth` under it [m]. `poses` has the objects.
  Surface find(Poses& poses, Vec3 x, double step, double depth);
  // The same, but for what is higher than kStepsOver above `x` and too narrow to step on: a bar, a rung, a rim.
  Surface find_footing(Poses& poses, Vec3 x, double step, double depth);
  // The same as find() and find_footing() of static geometry alone.
  Surface find_static(Vec3 x, double step, double depth);
  Surface find_static_footing(Vec3 x, double step, double depth);

 private:
  bool passes(const char* own, int name) const;
  bool wide(Vec3 x, double height);
  template <class Find>
  Surface past_narrow(Vec3 x, double step, const Find& find);
  void meet(const PosedShape& shape, int number, double layer, Vec3 x, double above, Surface& best);

  const CollisionWorld& world_;
  std::vector<int> objects_;  // shapes that are no person's
  std::vector<char> ghost_;   // per static: the person passes through it
  Convex point_;
  PosedShape probe_;
};

}  // namespace hp
