// A leg whose sole is put elsewhere: hip, knee and ankle turn, the foot keeps its orientation.
//
// Thigh (hip to knee, u) and shank (knee to ankle, w) are two bones. The shank turns about the
// knee's axis n until the ankle is as far from the hip as it is to be, a closed form:
//
//   |u + w(delta)|^2 = d^2,   w(delta) = w_n + w_t cos(delta) + (n x w_t) sin(delta)
//
// of the two solutions the one with the knee bent; then both turn about the hip by the least
// rotation that puts the ankle in its place. The axis is the thigh's own, from left to right, whatever the
// plane in which a recording has the leg: about the axis of that plane, which of a leg that is all but
// straight is noise, knees bent sideways by 20 degrees.
//
// A knee hardly turns aside: beyond its range that turn is taken back, and the knee bent anew, until both are right.
// Joints with ranges stay within them, or within what the motion itself asks: a shift that hip or knee cannot
// make is made as far as they can, and where the ankle cannot keep the foot's orientation the foot tilts, and
// the ankle rises by as much as the sole would come down into the ground.
#pragma once
#include <vector>

#include "dynamics/joint_range.h"
#include "footing/skin_point.h"

namespace hp {

struct Leg {
  int hip = 0, knee = 0, ankle = 0, toes = 0;       // bodies
  int hip_qpos = 0, knee_qpos = 0, ankle_qpos = 0;  // their quaternions in the model's qpos
  int root = 0;                                     // the body that the hip hangs on
  std::vector<SkinPoint> sole;
  std::vector<JointRange> ranges;  // of hip, knee and ankle; empty: they have none

  // Where a foot is to be.
  struct Place {
    Vec3 ankle;  // [m]
    Quat foot;   // the ankle's frame in the world
  };

  // How much farther down the ankle can go while the hip stays, moved by `shift` along the ground [m];
  // negative: it has to come up.
  double slack(const Kinematics& k, Vec3 shift) const;
  // Puts the foot of the pose `k`, whose coordinates are `qpos`, to `place`, or as near to it as the leg
  // reaches; the quaternions in qpos change, `k` does not. Points of the sole of a foot that tilts stay over `ground`,
  // the height of what is below each [m]. Returns the ankle's place, without what a foot that tilts needs besides.
  Vec3 move(const Kinematics& k, const Place& place, const std::vector<double>& ground,
            double* qpos) const;

 private:
  struct Bent {
    Quat hip, knee, ankle;  // of the joints
    Place foot;
  };
  double reach(const Kinematics& k) const;
  Bent bend(const Kinematics& k, const Place& place, const Bent& asked_joints) const;
  Bent within(const Kinematics& k, const Place& place, const Bent& asked) const;
  bool holds(const Bent& b, const Bent& asked) const;
  double sinks(const Kinematics& k, const Place& made, Quat asked,
               const std::vector<double>& ground) const;
};

}  // namespace hp
