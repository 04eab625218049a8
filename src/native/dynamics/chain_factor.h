// The factor of a joint-space matrix whose rows are stored along the chains of dofs, M = L^T D L
// (Featherstone 2008, ch. 6): each dof's row reaches as far as its ancestors.
//
// For matrices that are no inertia of an articulated body: those of people whose joints give in
// (stepping/strength.h), where M^ - M is scaled dof by dof. All others: inertia_factor.h.
#pragma once
#include <vector>

#include "dynamics/inertia.h"

namespace hp {

class ChainFactor {
 public:
  // Factors A = M + T (M) T + diag(scale_i extra_i), T = diag(sqrt(scale_i - 1)), of a tree.
  // With `free` (per dof) only of those, as if the others could not move. Writes
  // 1 / D.
  void factor(const Model& m, const Inertia& inertia, const Model::Tree& tree,
              const std::vector<double>& scale, const std::vector<double>& extra, const char* free,
              double* inv_D);
  // Row of L of a dof, along its chain of ancestors.
  const double* row(const Model& m, int dof) const { return &L_[m.row_start[dof]]; }

 private:
  std::vector<double> L_;
};

}  // namespace hp
