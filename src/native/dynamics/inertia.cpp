#include "dynamics/inertia.h"

namespace hp {

Inertia::Composite Inertia::of_body(const Model& m, const Kinematics& k, int b) {
  Composite c;
  Vec3 r = k.xpos[b] + k.xmat[b] * m.ipos[b] - k.reference(m, b);
  double mass = m.mass[b];
  Mat3 R = k.xmat[b] * to_matrix(m.iquat[b]);
  c.mass = mass;
  c.moment = mass * r;
  double rr = norm2(r);
  static const int row[6] = {0, 1, 2, 0, 0, 1}, col[6] = {0, 1, 2, 1, 2, 2};
  for (int e = 0; e < 6; e++) {
    int i = row[e], j = col[e];
    double s = 0;
    for (int a = 0; a < 3; a++) s += R.m[3 * i + a] * m.inertia[b][a] * R.m[3 * j + a];
    c.I[e] = s + mass * ((i == j ? rr : 0) - r[i] * r[j]);
  }
  return c;
}

void Inertia::compose(const Model& m, const Kinematics& k, const char* active) {
  own_.assign(m.nbody, {});
  axes_ = k.cdof;
  diagonal_.resize(m.nv);
  for (int b = 1; b < m.nbody; b++)
    if (!active || active[b]) own_[b] = of_body(m, k, b);
  composite_ = own_;
  for (int b = m.nbody - 1; b > 0; b--) {
    const int p = m.parent[b];
    if (active && !active[b]) continue;
    const Composite& c = composite_[b];
    for (int i = m.dof_first[b]; i < m.dof_first[b] + m.dof_count[b]; i++)
      diagonal_[i] = dot(axes_[i], c * axes_[i]) + m.armature[i];
    if (p == 0) continue;
    composite_[p].mass += c.mass;
    composite_[p].moment += c.moment;
    for (int e = 0; e < 6; e++) composite_[p].I[e] += c.I[e];
  }
}

void Inertia::multiply(const Model& m, const Model::Tree& tree, const double* x,
                       double* out) const {
  twists_.resize(m.nbody);
  momenta_.resize(m.nbody);
  for (int b = tree.first; b <= tree.last; b++) {
    Twist t = b == tree.first ? Twist{} : twists_[m.parent[b]];
    for (int i = m.dof_first[b]; i < m.dof_first[b] + m.dof_count[b]; i++)
      t = t + scaled(x[i], axes_[i]);
    twists_[b] = t;
    momenta_[b] = own_[b] * t;
  }
  for (int b = tree.last; b >= tree.first; b--) {
    for (int i = m.dof_first[b]; i < m.dof_first[b] + m.dof_count[b]; i++)
      out[i] = dot(axes_[i], momenta_[b]) + m.armature[i] * x[i];
    if (b > tree.first) momenta_[m.parent[b]] = momenta_[m.parent[b]] + momenta_[b];
  }
}

void Inertia::rows(const Model& m, const Model::Tree& tree, std::vector<double>& M) const {
  M.resize(m.chain.size());
  for (int i = tree.first_dof; i < tree.dof_end; i++) {
    // Momentum of the subtree under unit velocity of this dof.
    const Twist momentum = composite_[m.dof_body[i]] * axes_[i];
    double* row = &M[m.row_start[i]];
    const int* dof = &m.chain[m.row_start[i]];
    for (int a = 0; a < m.row_size[i]; a++) row[a] = dot(axes_[dof[a]], momentum);
    row[m.row_size[i] - 1] += m.armature[i];
  }
}

}  // namespace hp
