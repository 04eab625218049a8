#include "dynamics/half_solve.h"

#include <algorithm>

#include "math/simd.h"

namespace hp {

void HalfSolve::begin(const Model& m) {
  wrench_.assign(24 * (size_t)m.nbody, 0.0);
  force_.assign(4 * (size_t)m.nv, 0.0);
  reached_.assign(m.nbody, 0);
  waiting_ = last_ = 0;
}

void HalfSolve::reach(int body) {
  if (reached_[body]) return;
  reached_[body] = 1;
  waiting_++;
  last_ = std::max(last_, body);
}

void HalfSolve::add_wrench(int body, const Vec3 moment[3], const Vec3 force[3]) {
  reach(body);
  double* p = &wrench_[24 * (size_t)body];
  for (int q = 0; q < 3; q++)
    for (int k = 0; k < 3; k++) {
      p[4 * k + q] += moment[q][k];
      p[12 + 4 * k + q] += force[q][k];
    }
}

void HalfSolve::add_force(const Model& m, int dof, const double force[3]) {
  reach(m.dof_body[dof]);
  for (int q = 0; q < 3; q++) force_[4 * (size_t)dof + q] += force[q];
}

void HalfSolve::sweep(const Model& m, const InertiaFactor& factor, std::vector<int>& dofs,
                      std::vector<double>& y) {
  const size_t first = dofs.size();
  bool chains = false;
  for (int b = last_; waiting_ > 0; b--) {
    if (!reached_[b]) continue;
    reached_[b] = 0;
    waiting_--;
    double* p = &wrench_[24 * (size_t)b];
    if (m.dof_count[b] > 0) sweep_body(m, factor, b, dofs, y);
    chains |= factor.chains(b);
    if (const int parent = m.parent[b]; parent > 0) {
      reach(parent);
      add_scaled(&wrench_[24 * (size_t)parent], 1, p, 24);
    }
    std::fill_n(p, 24, 0.0);
  }
  last_ = 0;
  if (chains) sweep_chains(m, factor, first, dofs, y);
  for (size_t e = first; e < dofs.size(); e++)
    for (int q = 0; q < 3; q++) y[4 * e + q] *= factor.root_D()[dofs[e]];
}

void HalfSolve::sweep_body(const Model& m, const InertiaFactor& factor, int body,
                           std::vector<int>& dofs, std::vector<double>& y) {
  const int first = m.dof_first[body], count = m.dof_count[body];
  const size_t at = y.size();
  y.resize(at + 4 * (size_t)count);
  for (int i = first + count - 1; i >= first; i--) dofs.push_back(i);
  double* force = &force_[4 * (size_t)first];
  pass_up(&wrench_[24 * (size_t)body], &factor.axes()[first].w.x, &factor.gains()[first].w.x, count,
          force, &y[at]);
  std::fill_n(force, 4 * count, 0.0);
}

// Trees that are factored along chains: what is in y are the generalised forces.
void HalfSolve::sweep_chains(const Model& m, const InertiaFactor& factor, size_t first,
                             const std::vector<int>& dofs, std::vector<double>& y) {
  for (size_t e = first; e < dofs.size(); e++)
    std::copy_n(&y[4 * e], 4, &force_[4 * (size_t)dofs[e]]);
  for (size_t e = first; e < dofs.size(); e++) {
    const int i = dofs[e];
    double* x = &force_[4 * (size_t)i];
    const int* dof = &m.chain[m.row_start[i]];
    for (int a = 0; a < m.row_size[i] - 1 && factor.chains(m.dof_body[i]); a++)
      add_scaled(&force_[4 * (size_t)dof[a]], -factor.chain_row(m, i)[a], x, 4);
    std::copy_n(x, 4, &y[4 * e]);
    std::fill_n(x, 4, 0.0);
  }
}

}  // namespace hp
