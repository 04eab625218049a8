#include "dynamics/kinematic_tree.h"

#include <stdexcept>

#include "math/simd.h"

namespace hp {

void Model::finish() {
  held.assign(nbody, 0);
  auto need = [](bool ok, const char* what) {
    if (!ok) throw std::invalid_argument(what);
  };
  need(nbody >= 1 && (int)parent.size() == nbody, "model: bad number of bodies");
  root.assign(nbody, 0);
  last_dof.assign(nbody, -1);
  dof_body.assign(nv, 0);
  for (int b = 1; b < nbody; b++) {
    need(parent[b] >= 0 && parent[b] < b, "model: parents must precede their children");
    root[b] = parent[b] == 0 ? b : root[parent[b]];
    last_dof[b] = dof_count[b] > 0 ? dof_first[b] + dof_count[b] - 1 : last_dof[parent[b]];
    for (int i = 0; i < dof_count[b]; i++) dof_body[dof_first[b] + i] = b;
  }
  carried = mass;
  for (int b = nbody - 1; b > 0; b--) carried[parent[b]] += carried[b];
  plain_ball.assign(nbody, 0);
  for (int b = 1; b < nbody; b++) {
    int j = jnt_first[b];
    plain_ball[b] =
        jnt_count[b] == 1 && jnt_type[j] == Joint::Ball && norm2(jnt_pos[j]) == 0 && quat[b].w == 1;
  }
  row_start.assign(nv, 0);
  row_size.assign(nv, 0);
  chain.clear();
  for (int i = 0; i < nv; i++) {
    int b = dof_body[i], up = i > dof_first[b] ? i - 1 : last_dof[parent[b]];
    row_start[i] = (int)chain.size();
    if (up >= 0) {
      for (int k = 0; k < row_size[up]; k++) {
        int ancestor = chain[row_start[up] + k];
        chain.push_back(ancestor);
      }
    }
    chain.push_back(i);
    row_size[i] = (int)chain.size() - row_start[i];
  }
}

void Kinematics::resize(const Model& m) {
  xpos.resize(m.nbody);
  xquat.resize(m.nbody);
  xmat.resize(m.nbody);
  cdof.resize(m.nv);
}

void Kinematics::update(const Model& m, const double* qpos, const char* active) {
  for (int b = 1; b < m.nbody; b++) {
    if (active && !active[b]) continue;
    int p = m.parent[b], j0 = m.jnt_first[b], nj = m.jnt_count[b];
    Vec3 pos;
    Quat quat;
    if (nj == 1 && m.jnt_type[j0] == Joint::Free) {
      const double* q = qpos + m.jnt_qpos[j0];
      pos = load3(q);
      quat = normalized(load4(q + 3));
    } else if (m.plain_ball[b]) {
      pos = xpos[p] + xmat[p] * m.pos[b];
      quat = normalized(xquat[p] * load4(qpos + m.jnt_qpos[j0]));
    } else {
      pos = xpos[p] + xmat[p] * m.pos[b];
      quat = xquat[p] * m.quat[b];
      for (int j = j0; j < j0 + nj; j++) {
        const double* q = qpos + m.jnt_qpos[j];
        double q0 = m.qpos0[m.jnt_qpos[j]];
        Mat3 R = to_matrix(quat);
        Vec3 anchor = pos + R * m.jnt_pos[j];
        if (m.jnt_type[j] == Joint::Slide) {
          pos += (q[0] - q0) * (R * m.jnt_axis[j]);
          continue;
        }
        quat = quat * (m.jnt_type[j] == Joint::Ball ? normalized(load4(q))
                                                    : exp_quat((q[0] - q0) * m.jnt_axis[j]));
        pos = anchor - to_matrix(quat) * m.jnt_pos[j];
      }
      quat = normalized(quat);
    }
    xpos[b] = pos;
    xquat[b] = quat;
    xmat[b] = to_matrix(quat);
  }
}

void Kinematics::update_dofs(const Model& m, const double* qpos, const char* active) {
  for (int b = 1; b < m.nbody; b++) {
    if (m.dof_count[b] == 0 || (active && !active[b])) continue;
    Vec3 ref = reference(m, b);
    int nj = m.jnt_count[b], j0 = m.jnt_first[b];
    if (m.plain_ball[b]) {
      for (int k = 0; k < 3; k++) {
        Vec3 axis = xmat[b].col(k);
        cdof[m.jnt_dof[j0] + k] = {axis, cross(axis, ref - xpos[b])};
      }
      continue;
    }
    // One rotating joint per body, or several (hinges and slides) applied in turn: for those the
    // frames between are rebuilt.
    Vec3 pos = xpos[m.parent[b]] + xmat[m.parent[b]] * m.pos[b];
    Quat quat = xquat[m.parent[b]] * m.quat[b];
    for (int j = j0; j < j0 + nj; j++) {
      Twist* d = &cdof[m.jnt_dof[j]];
      if (m.jnt_type[j] == Joint::Free) {
        for (int k = 0; k < 3; k++) {
          Vec3 e;
          e[k] = 1;
          d[k] = {{0, 0, 0}, e};
          Vec3 axis = xmat[b].col(k);
          d[3 + k] = {axis, cross(axis, ref - xpos[b])};
        }
        continue;
      }
      const double* q = qpos + m.jnt_qpos[j];
      double q0 = m.qpos0[m.jnt_qpos[j]];
      Mat3 R = to_matrix(quat);
      Vec3 anchor = pos + R * m.jnt_pos[j];
      if (m.jnt_type[j] == Joint::Ball) {
        for (int k = 0; k < 3; k++) {
          Vec3 axis = xmat[b].col(k);
          d[k] = {axis, cross(axis, ref - anchor)};
        }
        quat = quat * normalized(load4(q));
        pos = anchor - to_matrix(quat) * m.jnt_pos[j];
        continue;
      }
      Vec3 axis = R * m.jnt_axis[j];
      if (m.jnt_type[j] == Joint::Slide) {
        d[0] = {{0, 0, 0}, axis};
        pos += (q[0] - q0) * axis;
      } else {
        d[0] = {axis, cross(axis, ref - anchor)};
        quat = quat * exp_quat((q[0] - q0) * m.jnt_axis[j]);
        pos = anchor - to_matrix(quat) * m.jnt_pos[j];
      }
    }
  }
}

void body_twists(const Model& m, const Kinematics& k, const double* qvel, std::vector<Twist>& out) {
  out.resize(m.nbody);
  out[0] = {};
  for (int b = 1; b < m.nbody; b++) {
    Twist t = m.parent[b] == 0 ? Twist{} : out[m.parent[b]];
    for (int i = m.dof_first[b]; i < m.dof_first[b] + m.dof_count[b]; i++) {
      t.w += qvel[i] * k.cdof[i].w;
      t.v += qvel[i] * k.cdof[i].v;
    }
    out[b] = t;
  }
}

void carry(const Model& m, const Kinematics& k, const double* qvel, int body, Twist& velocity,
           Twist& acceleration) {
  const int first = m.jnt_first[body];
  for (int j = first; j < first + m.jnt_count[body]; j++) {
    int d = m.jnt_dof[j];
    const bool free = m.jnt_type[j] == Joint::Free;
    for (int i = 0; free && i < 3; i++, d++) velocity = velocity + scaled(qvel[d], k.cdof[d]);
    const Twist before = velocity;
    for (int i = free || m.jnt_type[j] == Joint::Ball ? 3 : 1; i > 0; i--, d++) {
      acceleration = acceleration + scaled(qvel[d], cross_motion(before, k.cdof[d]));
      velocity = velocity + scaled(qvel[d], k.cdof[d]);
    }
  }
}

void integrate(const Model& m, double* qpos, const double* qvel, double t, const char* active) {
  for (int j = 0; j < m.njnt; j++) {
    if (active && !active[m.jnt_body[j]]) continue;
    double* q = qpos + m.jnt_qpos[j];
    const double* v = qvel + m.jnt_dof[j];
    switch (m.jnt_type[j]) {
      case Joint::Free:
        for (int k = 0; k < 3; k++) q[k] += t * v[k];
        store4(q + 3, normalized(load4(q + 3) * exp_quat(t * load3(v + 3))));
        break;
      case Joint::Ball:
        store4(q, normalized(load4(q) * exp_quat(t * load3(v))));
        break;
      default:
        q[0] += t * v[0];
    }
  }
}

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

Twist Inertia::Composite::operator*(const Twist& s) const {
  return {
      Vec3{I[0] * s.w.x + I[3] * s.w.y + I[4] * s.w.z, I[3] * s.w.x + I[1] * s.w.y + I[5] * s.w.z,
           I[4] * s.w.x + I[5] * s.w.y + I[2] * s.w.z} +
          cross(moment, s.v),
      mass * s.v + cross(s.w, moment)};
}

void Inertia::compose(const Model& m, const Kinematics& k, const char* active) {
  composite_.assign(m.nbody, {});
  for (int b = 1; b < m.nbody; b++)
    if (!active || active[b]) composite_[b] = of_body(m, k, b);
  for (int b = m.nbody - 1; b > 0; b--) {
    int p = m.parent[b];
    if (p == 0 || (active && !active[b])) continue;
    composite_[p].mass += composite_[b].mass;
    composite_[p].moment += composite_[b].moment;
    for (int e = 0; e < 6; e++) composite_[p].I[e] += composite_[b].I[e];
  }
  M.resize(m.chain.size());
  for (int i = 0; i < m.nv; i++) {
    if (active && !active[m.dof_body[i]]) continue;
    // Momentum of the subtree under unit velocity of this dof, about the reference point.
    const Twist momentum = composite_[m.dof_body[i]] * k.cdof[i];
    double* row = &M[m.row_start[i]];
    const int* dof = &m.chain[m.row_start[i]];
    for (int a = 0; a < m.row_size[i]; a++)
      row[a] = dot(k.cdof[dof[a]].w, momentum.w) + dot(k.cdof[dof[a]].v, momentum.v);
    row[m.row_size[i] - 1] += m.armature[i];
  }
}

void Inertia::factor(const Model& m, const std::vector<double>& scale,
                     const std::vector<double>& extra, const char* active, const char* free) {
  auto stays = [&](int dof) {
    return (active && !active[m.dof_body[dof]]) || (free && !free[dof]);
  };
  L.resize(M.size());
  inv_D.resize(m.nv);
  root_D.resize(m.nv);
  for (int i = 0; i < m.nv; i++) {
    int start = m.row_start[i], n = m.row_size[i];
    if (stays(i)) {
      std::fill_n(&L[start], n, 0.0);
      inv_D[i] = root_D[i] = 0;
      continue;
    }
    for (int a = 0; a < n; a++) {
      const double other = scale[m.chain[start + a]];
      const double s = other == scale[i] ? other : 1 + std::sqrt((scale[i] - 1) * (other - 1));
      L[start + a] = s * M[start + a];
    }
    L[start + n - 1] += scale[i] * extra[i];
    for (int a = 0; free && a < n - 1; a++)
      if (!free[m.chain[start + a]]) L[start + a] = 0;
  }
  // Chain by chain from its end: of a ball's three dofs each leaves the rows of those before it, then
  // all three together those of the ancestors that they share.
  for (int i = m.nv - 1, count; i >= 0; i -= count) {
    count = 1;
    if (active && !active[m.dof_body[i]]) continue;
    const int* dof = &m.chain[m.row_start[i]];
    while (count < 3 && i - count >= m.dof_first[m.dof_body[i]]) count++;
    const int shared = m.row_size[i] - count;
    double f[3] = {0, 0, 0};
    const double* t[3] = {&L[m.row_start[i]], &L[m.row_start[i]], &L[m.row_start[i]]};
    for (int k = 0; k < count; k++) {
      double* row = &L[m.row_start[i - k]];
      const int n = m.row_size[i - k] - 1;
      t[k] = row;
      if (stays(i - k)) continue;
      f[k] = inv_D[i - k] = 1 / row[n];
      root_D[i - k] = std::sqrt(f[k]);
      for (int a = n - 1; a >= shared; a--) {
        double* up = &L[m.row_start[dof[a]]];
        for (int c = 0; c <= a; c++) up[c] -= row[a] * f[k] * row[c];
      }
    }
    eliminate(L.data(), m.row_start.data(), dof, shared, t[0], t[1], t[2], f);
    for (int k = 0; k < count; k++)
      for (int a = 0; a < m.row_size[i - k] - 1; a++) L[m.row_start[i - k] + a] *= f[k];
  }
}

void Inertia::solve(const Model& m, double* x) const {
  for (int i = m.nv - 1; i >= 0; i--) {
    const double* row = &L[m.row_start[i]];
    const int* dof = &m.chain[m.row_start[i]];
    double t = x[i];
    if (t == 0) continue;
    for (int a = 0; a < m.row_size[i] - 1; a++) x[dof[a]] -= row[a] * t;
  }
  for (int i = 0; i < m.nv; i++) x[i] *= inv_D[i];
  half_solve_back(m, x);
}

void Inertia::half_solve_back(const Model& m, double* x) const {
  for (int i = 0; i < m.nv; i++) {
    const double* row = &L[m.row_start[i]];
    const int* dof = &m.chain[m.row_start[i]];
    double t = x[i];
    for (int a = 0; a < m.row_size[i] - 1; a++) t -= row[a] * x[dof[a]];
    x[i] = t;
  }
}

void Inertia::multiply(const Model& m, int first, int last, const double* x, double* out) const {
  shared_.resize(2 * (size_t)m.nv);
  for (int b = first; b <= last; b++) std::fill_n(out + m.dof_first[b], m.dof_count[b], 0.0);
  for (int b = first; b <= last; b++) {
    const int from = m.dof_first[b], count = m.dof_count[b];
    if (count == 0) continue;
    const int n = m.row_size[from] - 1;
    const int* dof = &m.chain[m.row_start[from]];
    double *up = shared_.data(), *back = up + m.nv;  // x of the ancestors, and what they get
    for (int a = 0; a < n; a++) up[a] = x[dof[a]], back[a] = 0;
    for (int i = from; i < from + count; i++) {
      const double* row = &M[m.row_start[i]];
      out[i] += inner(row, up, n) + row[n + i - from] * x[i];
      for (int j = from; j < i; j++) {
        out[i] += row[n + j - from] * x[j];
        out[j] += row[n + j - from] * x[i];
      }
      add_scaled(back, x[i], row, n);
    }
    for (int a = 0; a < n; a++) out[dof[a]] += back[a];
  }
}

}  // namespace hp
