// The factor A = L^T D L of a joint-space matrix A = s (M + diag(extra)), and its half solves.
//
// Of a tree with one s it is that of its articulated bodies, O(n) (Featherstone 2008, ch. 7): from the
// leaves on, each dof i with axis S_i takes of its body's articulated inertia I what it gives way to,
//     U = I S_i,   d = S_i.U + armature + extra,   I <- I - U U^T / d,
// and what is left is added to the parent's. Row i of L is U.S_j / d at its ancestors j, so that L and
// its transpose are applied by sweeps along the tree with K = U / d: never as numbers. Trees whose dofs
// differ in s have the factor along chains (chain_factor.h) instead.
//
// A half solve of rows of a Jacobian J, y = D^-1/2 L^-T J^T, goes up the tree with their wrenches:
// half_solve.h.
#pragma once
#include <vector>

#include "dynamics/chain_factor.h"
#include "dynamics/inertia.h"

namespace hp {

class InertiaFactor {
 public:
  // Factors scale_i (M + diag(extra)); scale of one tree may differ where the diagonal of M + T M T is
  // meant (chain_factor.h). With `active` (per body) only of those trees: whatever is solved for, the
  // others stay at zero. With `free` (per dof) only of those, as if the others could not move.
  void factor(const Model& m, const Inertia& inertia, const std::vector<double>& scale,
              const std::vector<double>& extra, const char* active = nullptr,
              const char* free = nullptr);
  void solve(const Model& m, double* x) const;  // x <- A^-1 x
  // x <- L^-1 D^-1/2 x, and the twists of all bodies under the velocities that this is.
  void half_solve_back(const Model& m, double* x, std::vector<Twist>& twists) const;

  // The tree of a body is factored along chains.
  bool chains(int body) const { return chains_[body] != 0; }
  const double* chain_row(const Model& m, int dof) const { return chain_.row(m, dof); }
  // Of dofs: axes, K, and D^-1/2.
  const Twist* axes() const { return axes_.data(); }
  const Twist* gains() const { return K_.data(); }
  const double* root_D() const { return root_D_.data(); }

 private:
  void factor_tree(const Model& m, const Inertia& inertia, const Model::Tree& tree, double scale,
                   const std::vector<double>& extra, const char* free);
  void take_back(const Model& m, double* x, std::vector<Twist>& twists) const;

  ChainFactor chain_;
  std::vector<char> chains_;            // per body
  std::vector<double> inv_D_, root_D_;  // per dof; 0: it does not move
  std::vector<Twist> axes_, K_;
  std::vector<double> articulated_;  // per body: 6 rows of 8, the last two of each zero
  mutable std::vector<Twist> forces_, twists_;
};

}  // namespace hp
