// How far points that bodies carry stray from the straight line between their ends, on the way from
// one pose to another that constant joint velocities take.
//
// Time runs from 0 to 1. With theta the angle that a joint turns by, S bounds the angular speed of a
// body, B that of its turning and A the acceleration of its origin; along a chain, with d the
// distance between origins,
//
//     S = S_parent + theta,  B = B_parent + S_parent theta,  A = A_parent + (S_parent^2 + B_parent) d,
//
// and S is at most the angle between the two ends plus B. A point at r from the origin accelerates
// by at most A + (S^2 + B) r, and strays by at most an eighth of that (the sagitta). It sees the
// arcs of all joints up to the root, not of the body's own alone.
//
// Angles in [rad], lengths in [m].
#pragma once
#include <vector>

#include "collision/poses.h"

namespace hp {

class PathBounds {
 public:
  // `way`: how far each degree of freedom goes.
  void find(const Model& m, const Kinematics& from, const Kinematics& to,
            const std::vector<double>& way);
  double spin(int body) const { return spin_[body]; }
  // Upper bounds of the acceleration of all points of a shape; and of points within `reach` of a
  // body's origin that stand in its frame.
  double acceleration(const CollisionShape& shape) const;
  double acceleration(int body, double reach) const {
    return acceleration_[body] + (spin_[body] * spin_[body] + turn_[body]) * reach;
  }

 private:
  void add_joint(const Model& m, int joint, const double* way, int body);

  std::vector<double> angle_, spin_, turn_, acceleration_;  // per body: theta, S, B and A
};

}  // namespace hp
