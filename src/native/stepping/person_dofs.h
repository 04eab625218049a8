// Where a person's degrees of freedom are: a free root and ball joints, contiguous in the model.
//
// Balls are numbered in the model's order, the root's rotation first. In qpos a person has 3 + 4
// per ball numbers, in qvel 3 + 3 per ball.
#pragma once
#include <vector>

#include "dynamics/kinematic_tree.h"

namespace hp {

class PersonDofs {
 public:
  struct Ball {
    int qpos, dof;  // relative to the person's first
    int body;
  };

  // Throws std::invalid_argument unless the tree that hangs on `root_body` is a person's.
  PersonDofs(const Model& m, int root_body);

  int first_qpos() const { return qpos0_; }
  int first_dof() const { return dof0_; }
  int qpos_count() const { return nq_; }
  int dof_count() const { return nv_; }
  const std::vector<Ball>& balls() const { return balls_; }
  int ball_count() const { return (int)balls_.size(); }
  int body(int ball) const { return balls_[ball].body; }
  int ball_dof(int ball) const { return dof0_ + balls_[ball].dof; }
  // The first of three dofs that a limit of strength is of: 0 the root's position, i + 1 ball i.
  int limit_dof(int limit) const { return limit == 0 ? dof0_ : ball_dof(limit - 1); }

 private:
  int qpos0_, dof0_, nq_, nv_;
  std::vector<Ball> balls_;
};

}  // namespace hp
