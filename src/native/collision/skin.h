// A person's skin as the collision shapes see it: linear blend skinning with pose blend shapes
// (SMPL: Loper et al. 2015, "SMPL: A Skinned Multi-Person Linear Model").
//
// A vertex with rest position x_rest, joint weights w_j (sum 1) and pose blend shapes B is at
//
//     x = sum_j w_j (R_j (x_rest + B vec(R_local - I) - p_j) + c_j)
//
// where p_j is joint j at rest, (R_j, c_j) its frame in the world, and R_local stacks the rotations
// of all joints but the root relative to their parents. Lengths in [m].
#pragma once
#include <vector>

#include "math/vec.h"

namespace hp {

struct Skin {
  std::vector<int> body, parent, dof;  // per joint: the model's body, the parent joint, first dof
  std::vector<Vec3> joint;             // per joint: position at rest, p_j
  std::vector<Vec3> rest;              // per vertex: position at rest, x_rest
  // Vertex v has the weights first_weight[v] ... first_weight[v + 1] - 1, of the joints
  // weight_joint.
  std::vector<int> first_weight, weight_joint;
  std::vector<double> weight;
  std::vector<double> pose_blend;  // B: vertices x 3 x features(); empty: no pose blend shapes
  // Entries of R_local - I: nine per joint but the root.
  int features() const { return 9 * ((int)joint.size() - 1); }
};

}  // namespace hp
