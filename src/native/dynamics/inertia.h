// Inertia of trees of rigid bodies: of each body, of what hangs on it, and what follows in joint space.
//
// The joint-space matrix M is rarely needed as numbers. Its products M x are momenta: every body's
// momentum under the velocities x, added up from the leaves and taken along the joints' axes, O(n)
// (Featherstone 2008, ch. 5). Its factor is inertia_factor.h. All spatial vectors are about the
// reference point of the body's tree, in the world's axes.
#pragma once
#include <vector>

#include "dynamics/kinematic_tree.h"

namespace hp {

struct Inertia {
  // Of a rigid body, or of several that move as one, about the reference point.
  struct Composite {
    double mass = 0;
    Vec3 moment;                       // mass times centre of mass
    double I[6] = {0, 0, 0, 0, 0, 0};  // xx yy zz xy xz yz
    // Momentum under a motion: angular, linear.
    Twist operator*(const Twist& s) const {
      return {Vec3{I[0] * s.w.x + I[3] * s.w.y + I[4] * s.w.z,
                   I[3] * s.w.x + I[1] * s.w.y + I[5] * s.w.z,
                   I[4] * s.w.x + I[5] * s.w.y + I[2] * s.w.z} +
                  cross(moment, s.v),
              mass * s.v + cross(s.w, moment)};
    }
  };
  static Composite of_body(const Model& m, const Kinematics& k, int body);  // of it alone

  // At a pose whose dofs' axes are known; with `active` (per body) only of those trees.
  void compose(const Model& m, const Kinematics& k, const char* active = nullptr);
  // Of M, armature included.
  double diagonal(int dof) const { return diagonal_[dof]; }
  // out = M x on the dofs of a tree.
  void multiply(const Model& m, const Model::Tree& tree, const double* x, double* out) const;
  // The rows of M as Model::chain has them, of the dofs of a tree, into M.
  void rows(const Model& m, const Model::Tree& tree, std::vector<double>& M) const;

  const Composite& of(int body) const { return own_[body]; }
  // With all that hangs on it.
  const Composite& carried(int body) const { return composite_[body]; }
  const std::vector<Twist>& axes() const { return axes_; }  // per dof, at the pose

 private:
  std::vector<Composite> own_, composite_;
  std::vector<Twist> axes_;
  std::vector<double> diagonal_;
  mutable std::vector<Twist> twists_, momenta_;
};

}  // namespace hp
