#include "dynamics/kinematic_tree.h"

#include <stdexcept>

#include "tuning.h"

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
  trees.clear();
  for (int b = 1, dofs = 0; b < nbody; b++) {
    if (root[b] == b) trees.push_back({b, b, dofs, dofs});
    need(root[b] == trees.back().first, "model: bodies of a tree must follow each other");
    trees.back().last = b;
    trees.back().dof_end = dofs += dof_count[b];
  }
  add_up_masses();
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
    if (chain.size() + (up >= 0 ? row_size[up] : 0) > tuning::dynamics::kMostAncestors)
      throw std::invalid_argument("model: chains of joints are too deep");
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

void Model::add_up_masses() {
  carried = mass;
  for (int b = nbody - 1; b > 0; b--) carried[parent[b]] += carried[b];
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

}  // namespace hp
