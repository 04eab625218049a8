#include "assembly/model_check.h"

#include <cmath>
#include <stdexcept>

namespace hp::assembly {

namespace {

void need(bool ok, const char* what) {
  if (!ok) throw std::invalid_argument(what);
}

int dofs(Joint j) { return j == Joint::Free ? 6 : j == Joint::Ball ? 3 : 1; }

void check_sizes(const Model& m) {
  const size_t bodies = m.nbody, joints = m.njnt;
  for (const auto* v : {&m.parent, &m.jnt_first, &m.jnt_count, &m.dof_first, &m.dof_count})
    need(v->size() == bodies, "model: an array has not one entry per body");
  for (const auto* v : {&m.pos, &m.ipos, &m.inertia})
    need(v->size() == bodies, "model: an array has not one row per body");
  need(m.quat.size() == bodies && m.iquat.size() == bodies && m.mass.size() == bodies,
       "model: an array has not one row per body");
  for (const auto* v : {&m.jnt_qpos, &m.jnt_dof, &m.jnt_body})
    need(v->size() == joints, "model: an array has not one entry per joint");
  need(m.jnt_type.size() == joints && m.jnt_pos.size() == joints && m.jnt_axis.size() == joints,
       "model: an array has not one row per joint");
}

// The first joint and dof of a body that has none: MuJoCo writes -1.
void check_nothing(const Model& m, int body) {
  need(m.jnt_count[body] > 0 || (m.jnt_first[body] >= -1 && m.jnt_first[body] <= m.njnt),
       "model: joints are out of order");
  need(m.dof_count[body] > 0 || (m.dof_first[body] >= -1 && m.dof_first[body] <= m.nv),
       "model: dofs are out of order");
}

// The joints of a body, which begin with the coordinate and dof that come next.
void check_joints(const Model& m, int body, int& joint, int& qpos, int& dof) {
  need(m.jnt_count[body] >= 0 && m.dof_count[body] >= 0 && m.jnt_count[body] <= m.njnt - joint,
       "model: a body has too many joints");
  need(m.jnt_count[body] == 0 || m.jnt_first[body] == joint, "model: joints are out of order");
  need(m.dof_count[body] == 0 || m.dof_first[body] == dof, "model: dofs are out of order");
  const int first = dof;
  for (const int end = joint + m.jnt_count[body]; joint < end; joint++) {
    const Joint type = m.jnt_type[joint];
    need(type >= Joint::Free && type <= Joint::Hinge, "model: no such joint");
    need(type != Joint::Free || (m.jnt_count[body] == 1 && m.parent[body] == 0),
         "model: a free joint must be the only one of a body in the world");
    need(m.jnt_body[joint] == body && m.jnt_qpos[joint] == qpos && m.jnt_dof[joint] == dof,
         "model: joints are out of order");
    qpos += qpos_width(type), dof += dofs(type);
    need(qpos <= m.nq && dof <= m.nv, "model: a joint has no coordinates");
  }
  need(dof - first == m.dof_count[body], "model: a body has not the dofs of its joints");
}

bool positive(Vec3 v) { return v.x > 0 && v.y > 0 && v.z > 0; }

}  // namespace

void check_model(const Model& m) {
  check_sizes(m);
  need(m.nbody >= 1 && m.jnt_count[0] == 0 && m.dof_count[0] == 0, "model: the world moves");
  int joint = 0, qpos = 0, dof = 0;
  for (int b = 0; b < m.nbody; b++) check_nothing(m, b);
  for (int b = 1; b < m.nbody; b++) {
    need(m.parent[b] >= 0 && m.parent[b] < b, "model: parents must precede their children");
    check_joints(m, b, joint, qpos, dof);
    const Vec3 moments = m.inertia[b];
    need(m.mass[b] >= 0 && moments.x >= 0 && moments.y >= 0 && moments.z >= 0,
         "model: a mass or a moment of inertia below 0");
    need(m.jnt_count[b] == 0 || m.jnt_type[m.jnt_first[b]] != Joint::Free ||
             (m.mass[b] > 0 && positive(moments)),
         "model: what moves freely needs a mass and moments of inertia");
  }
  need(joint == m.njnt && qpos == m.nq && dof == m.nv, "model: joints without a body");
  for (double a : m.armature) need(a >= 0, "model: an armature below 0");
}

}  // namespace hp::assembly
