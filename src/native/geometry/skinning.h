// Forward kinematics and linear blend skinning with pose blend shapes, float64.
//
// A joint at rest at j_rest, turned by R in the world and at x, carries a vertex v to
//     R (v - j_rest) + x.
// The skin (Loper et al. 2015, SMPL) is the mean of that over the joints of a vertex, with the
// sparse weights w; before it is carried, a vertex is shifted by the pose blend shapes, which are
// linear in the entries of R_local - I of all joints but the root:
//     y = sum_j w_j (R_j (v + P vec(R_local - I) - j_rest) + x_j).
//
// The readable reference is src/halfphysics/skinning.py; tests hold the two equal. Every output
// value is computed by one thread, in an order that depends on nothing but its own frame and
// vertex: the bytes are the same for any number of threads, any batch and any subset.
#pragma once
#include <cstddef>

namespace hp {

// A mesh at rest and what skins it. Nothing is owned; indices must be in range.
struct SkinnedMesh {
  // Features of one joint in the pose blend shapes: the entries of its rotation matrix.
  static constexpr int joint_features = 9;

  const double *rest, *joints;  // vertices and joints at rest, 3 each [m]
  const double* weights;        // sparse, vertex by vertex
  const double* posedirs;       // (vertices, 3, n_features), null: no pose blend shapes
  const int *first, *joint;     // where each vertex' weights start, and their joints
  const int* subset;            // the vertices that come out, null: all
  size_t n_joints, n_out, n_features;
  // Groups of the vertices that come out: where each starts, and in which frames it is wanted
  // (frames, n_groups). Null: all are.
  const int* group_first;
  const unsigned char* wanted;
  size_t n_groups;
};

// Poses of all joints, frame by frame.
struct JointPoses {
  size_t frames;
  const double* rotations;    // local, axis-angle [rad], 3 per joint
  const double* positions;    // in the world [m], 3 per joint
  const double* quaternions;  // in the world, wxyz, 4 per joint
};

// World positions (frames, joints, 3) and quaternions (frames, joints, 4) of the joints of a
// skeleton whose parents precede their children; `root` is the root's position in each frame.
void joint_frames(const double* rotations, const double* root, const double* rest_joints,
                  const int* parents, size_t frames, size_t joints, double* positions,
                  double* quaternions);

// Skinned vertices (frames, n_out, 3) into `out`, by `threads` threads.
void skin(const SkinnedMesh& mesh, const JointPoses& poses, int threads, double* out);

}  // namespace hp
