#include "stepping/standing_load.h"

#include <algorithm>

#include "stepping/sleeping.h"

namespace hp {

namespace {

// Adds the generalised impulse of an impulse `p` at `at` on a body.
void push_body(const Model& m, const Kinematics& kin, int body, Vec3 at, Vec3 p, double* impulse) {
  const Vec3 turn = cross(at - kin.reference(m, body), p);
  const int last = m.last_dof[body];
  for (int i = m.row_start[last]; i < m.row_start[last] + m.row_size[last]; i++) {
    const int dof = m.chain[i];
    impulse[dof] += dot(kin.cdof[dof].w, turn) + dot(kin.cdof[dof].v, p);
  }
}

// From impulse to change of velocity, of an object: its frame is at its centre of mass.
void free_response(const Model& m, int body, double* impulse) {
  double* at = impulse + m.dof_first[body];
  store3(at, (1 / m.mass[body]) * load3(at));
  const Mat3 R = to_matrix(m.iquat[body]);
  Vec3 turn = mul_t(R, load3(at + 3));
  for (int i = 0; i < 3; i++) turn[i] /= m.inertia[body][i];
  store3(at + 3, R * turn);
}

}  // namespace

int pressing_shape(const System& system, int body) {
  const std::vector<CollisionShape>& shapes = system.world.shapes;
  for (; body > 0; body = system.model.parent[body])
    for (size_t i = 0; i < shapes.size(); i++)
      if (shapes[i].body == body) return (int)i;
  return 0;
}

void StandingLoad::wake(System& system, Data& data) const {
  std::vector<char> woken;
  for (const Drive& d : system.drives)
    for_loads(system, d, [&](size_t, int body, double) {
      const int root = system.model.root[body];
      if (!system.world.asleep[root]) return;
      system.world.asleep[root] = 0;
      woken.resize(system.model.nbody, 0);
      woken[root] = 1;
    });
  if (!woken.empty()) wake_neighbours(system, data, woken);
}

void StandingLoad::add(System& system, Data& data, double h) {
  const Model& model = system.model;
  const Kinematics& kin = data.state.pose.kin;
  bool any = false, jointed = false;
  for (Drive& d : system.drives) {
    if (!d.footing.on() || !d.footing.bearing.any()) continue;
    d.footing.bearing.advance(h);
    const double push = h * weight_of(system, d);
    for_loads(system, d, [&](size_t i, int body, double share) {
      if (!any) impulse_.assign(model.nv, 0);
      any = true;
      jointed |= system.articulations.jointed(body);
      push_body(model, kin, body, d.footing.bearing.points[i].at, {0, 0, -share * push},
                impulse_.data());
    });
  }
  if (!any) return;
  if (jointed) {
    data.inertia.build(system, data.state, data.step, h);
    data.inertia.solve(model, impulse_.data());
  } else {
    for (int b : system.objects)
      if (!model.held[b]) free_response(model, b, impulse_.data());
  }
  for (int i = 0; i < model.nv; i++) data.step.v_free[i] += impulse_[i];
  data.step.load = impulse_;
}

void StandingLoad::pressing(System& system, double h, std::vector<Pressing>& out) {
  for (Drive& d : system.drives) {
    if (!d.footing.on() || !d.footing.bearing.any()) continue;
    d.footing.bearing.advance(h);
    const double force = weight_of(system, d);
    for_loads(system, d, [&](size_t i, int, double share) {
      const BearingPoint& p = d.footing.bearing.points[i];
      const int person = pressing_shape(system, d.footing.model->bearing_body(i));
      out.push_back({p.shape, person, p.at, {0, 0, -share * force}});
    });
  }
}

void StandingLoad::end_frame(System& system, const FrameResult& result, double dt) {
  for (Drive& d : system.drives) {
    if (!d.footing.on()) continue;
    const int root = d.body(0);
    double up = 0;  // impulse on the person [N s]
    for (const Touch& t : result.touches) {
      if (t.shape < 0 || t.other_shape < 0) continue;
      const bool first = system.tree(t.shape) == root, second = system.tree(t.other_shape) == root;
      if (first == second) continue;
      const int other = system.world.shapes[first ? t.other_shape : t.shape].body;
      if (system.is_person(other) || system.model.pushed_dof(other) < 0) continue;
      up += first ? t.impulse.z : -t.impulse.z;
    }
    const double most = weight_of(system, d) * dt;
    d.footing.bearing.contacts_pressed(most > 0 ? std::max(0.0, up) / most : 0, dt);
  }
}

}  // namespace hp
