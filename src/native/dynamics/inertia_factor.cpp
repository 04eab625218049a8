#include "dynamics/inertia_factor.h"

#include "math/simd.h"

namespace hp {

namespace {

constexpr int kRow = 8, kSize = 6 * kRow;  // of an articulated inertia

// The 6 x 6 matrix of a rigid body's inertia, from motion (w, v) to momentum (angular, linear).
void write(const Inertia::Composite& c, double* at) {
  const double* I = c.I;
  const Vec3 p = c.moment;
  const double rows[6][6] = {{I[0], I[3], I[4], 0, -p.z, p.y}, {I[3], I[1], I[5], p.z, 0, -p.x},
                             {I[4], I[5], I[2], -p.y, p.x, 0}, {0, p.z, -p.y, c.mass, 0, 0},
                             {-p.z, 0, p.x, 0, c.mass, 0},     {p.y, -p.x, 0, 0, 0, c.mass}};
  for (int r = 0; r < 6; r++) {
    for (int q = 0; q < 6; q++) at[kRow * r + q] = rows[r][q];
    at[kRow * r + 6] = at[kRow * r + 7] = 0;
  }
}

}  // namespace

void InertiaFactor::factor(const Model& m, const Inertia& inertia, const std::vector<double>& scale,
                           const std::vector<double>& extra, const char* active, const char* free) {
  chains_.assign(m.nbody, 0);
  inv_D_.assign(m.nv, 0.0);
  root_D_.resize(m.nv);
  axes_ = inertia.axes();
  K_.assign(m.nv, {});
  articulated_.resize((size_t)kSize * m.nbody);
  for (const Model::Tree& tree : m.trees) {
    const int first = tree.first_dof;
    if (first == tree.dof_end || (active && !active[tree.first])) continue;
    bool one = true;
    for (int i = first; i < tree.dof_end; i++) one &= scale[i] == scale[first];
    if (one) {
      factor_tree(m, inertia, tree, scale[first], extra, free);
    } else {
      std::fill(chains_.begin() + tree.first, chains_.begin() + tree.last + 1, 1);
      chain_.factor(m, inertia, tree, scale, extra, free, inv_D_.data());
    }
  }
  for (int i = 0; i < m.nv; i++) root_D_[i] = std::sqrt(inv_D_[i]);
}

void InertiaFactor::factor_tree(const Model& m, const Inertia& inertia, const Model::Tree& tree,
                                double scale, const std::vector<double>& extra, const char* free) {
  double* all = articulated_.data();
  for (int b = tree.first; b <= tree.last; b++) write(inertia.of(b), all + (size_t)kSize * b);
  for (int b = tree.last; b >= tree.first; b--) {
    double* own = all + (size_t)kSize * b;
    for (int i = m.dof_first[b] + m.dof_count[b] - 1; i >= m.dof_first[b]; i--) {
      if (free && !free[i]) continue;
      const double d = give_way(own, &axes_[i].w.x, m.armature[i] + extra[i], &K_[i].w.x);
      inv_D_[i] = 1 / (scale * d);
    }
    if (b == tree.first) continue;
    double* parent = all + (size_t)kSize * m.parent[b];
    for (int e = 0; e < kSize; e++) parent[e] += own[e];
  }
}

// x <- L^-1 x: a body's velocity is what its parent's makes it give way to, and its own.
void InertiaFactor::take_back(const Model& m, double* x, std::vector<Twist>& twists) const {
  twists.resize(m.nbody);
  twists[0] = {};
  for (int b = 1; b < m.nbody; b++) {
    Twist t = m.parent[b] == 0 ? Twist{} : twists[m.parent[b]];
    for (int i = m.dof_first[b]; i < m.dof_first[b] + m.dof_count[b]; i++) {
      if (chains_[b]) {
        const double* row = chain_.row(m, i);
        const int* dof = &m.chain[m.row_start[i]];
        for (int a = 0; a < m.row_size[i] - 1; a++) x[i] -= row[a] * x[dof[a]];
      } else {
        x[i] -= dot(K_[i], t);
      }
      t = t + scaled(x[i], axes_[i]);
    }
    twists[b] = t;
  }
}

void InertiaFactor::half_solve_back(const Model& m, double* x, std::vector<Twist>& twists) const {
  for (int i = 0; i < m.nv; i++) x[i] *= root_D_[i];
  take_back(m, x, twists);
}

void InertiaFactor::solve(const Model& m, double* x) const {
  forces_.assign(m.nbody, {});
  for (int b = m.nbody - 1; b > 0; b--) {
    Twist& f = forces_[b];
    for (int i = m.dof_first[b] + m.dof_count[b] - 1; i >= m.dof_first[b]; i--) {
      if (chains_[b]) {
        const double* row = chain_.row(m, i);
        const int* dof = &m.chain[m.row_start[i]];
        for (int a = 0; a < m.row_size[i] - 1; a++) x[dof[a]] -= row[a] * x[i];
      } else {
        x[i] -= dot(axes_[i], f);
        f = f + scaled(x[i], K_[i]);
      }
    }
    if (m.parent[b] > 0) forces_[m.parent[b]] = forces_[m.parent[b]] + f;
  }
  for (int i = 0; i < m.nv; i++) x[i] *= inv_D_[i];
  take_back(m, x, twists_);
}

}  // namespace hp
