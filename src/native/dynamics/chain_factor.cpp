#include "dynamics/chain_factor.h"

#include "math/simd.h"

namespace hp {

void ChainFactor::factor(const Model& m, const Inertia& inertia, const Model::Tree& tree,
                         const std::vector<double>& scale, const std::vector<double>& extra,
                         const char* free, double* inv_D) {
  auto stays = [&](int dof) { return free && !free[dof]; };
  inertia.rows(m, tree, L_);
  for (int i = tree.first_dof; i < tree.dof_end; i++) {
    const int n = m.row_size[i];
    const int* chain = &m.chain[m.row_start[i]];
    double* row = &L_[m.row_start[i]];
    if (stays(i)) {
      std::fill_n(row, n, 0.0);
      inv_D[i] = 0;
      continue;
    }
    for (int a = 0; a < n; a++) {
      const double other = scale[chain[a]];
      row[a] *= other == scale[i] ? other : 1 + std::sqrt((scale[i] - 1) * (other - 1));
      if (stays(chain[a])) row[a] = 0;
    }
    row[n - 1] += scale[i] * extra[i];
  }
  // Chain by chain from its end: of a ball's three dofs each leaves the rows of those before it, then
  // all three together those of the ancestors that they share.
  for (int i = tree.dof_end - 1, count; i >= tree.first_dof; i -= count) {
    count = 1;
    const int* dof = &m.chain[m.row_start[i]];
    while (count < 3 && i - count >= m.dof_first[m.dof_body[i]]) count++;
    const int shared = m.row_size[i] - count;
    double f[3] = {0, 0, 0};
    const double* t[3] = {&L_[m.row_start[i]], &L_[m.row_start[i]], &L_[m.row_start[i]]};
    for (int k = 0; k < count; k++) {
      double* row = &L_[m.row_start[i - k]];
      const int n = m.row_size[i - k] - 1;
      t[k] = row;
      if (stays(i - k)) continue;
      f[k] = inv_D[i - k] = 1 / row[n];
      for (int a = n - 1; a >= shared; a--) {
        double* up = &L_[m.row_start[dof[a]]];
        for (int c = 0; c <= a; c++) up[c] -= row[a] * f[k] * row[c];
      }
    }
    eliminate(L_.data(), m.row_start.data(), dof, shared, t[0], t[1], t[2], f);
    for (int k = 0; k < count; k++)
      for (int a = 0; a < m.row_size[i - k] - 1; a++) L_[m.row_start[i - k] + a] *= f[k];
  }
}

}  // namespace hp
