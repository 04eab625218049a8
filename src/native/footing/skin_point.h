// A point of a person's skin, carried by the bodies of two joints at most.
#pragma once
#include "dynamics/kinematic_tree.h"

namespace hp {

struct SkinPoint {
  int body[2] = {0, 0};
  double weight[2] = {1, 0};
  Vec3 local[2];  // where it is in the frame of each [m]
  Vec3 normal;    // outward, in the frame of the first

  Vec3 position(const Kinematics& k) const {
    Vec3 x = weight[0] * (k.xpos[body[0]] + k.xmat[body[0]] * local[0]);
    if (weight[1] > 0) x += weight[1] * (k.xpos[body[1]] + k.xmat[body[1]] * local[1]);
    return x;
  }
  Vec3 facing(const Kinematics& k) const { return k.xmat[body[0]] * normal; }
};

}  // namespace hp
