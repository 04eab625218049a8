#include "stepping/free_motion.h"

namespace hp {

void FreeMotion::drive(System& system, Data& data, InternalForces& internal, int k, double h) {
  const Model& model = system.model;
  const World& world = system.world;
  const DriveSettings& settings = system.drive_settings;
  State& state = data.state;
  Step& step = data.step;
  step.v_free = state.qvel;
  impulse_.assign(model.nv, 0.0);
  bool any = false;
  for (const Drive& d : system.drives)
    if (system.active(d))
      any |= d.free_velocity(settings, k, h, state.qpos.data(), state.qvel.data(),
                             step.v_free.data(), impulse_.data());
  // A host has found what its own joints do.
  const bool trees = !step.host_v_free && system.articulations.any(model, world.active);
  const bool own = settings.own_forces();
  if (!any && !trees && !own) return;
  data.inertia.build(system, state, step, h);
  const std::vector<double>& added = data.inertia.drive_part();
  for (int i = 0; i < model.nv; i++) impulse_[i] *= added[i] / h;
  if (trees)
    system.articulations.impulse(model, state.pose.kin, world.active, system.gravity,
                                 state.qpos.data(), state.qvel.data(), h, impulse_.data());
  if (own) internal.add_impulses(system, state, step, h, impulse_);
  data.inertia.solve(model, impulse_.data());
  if (settings.internal_forces) internal.limit(system, step, impulse_);
  for (int i = 0; i < model.nv; i++) step.v_free[i] += impulse_[i];
  for (int i : system.articulations.dofs()) step.joint_pull[i] = impulse_[i];
}

namespace {

// The angular velocity w in the middle of a substep of a free body of inertia I that begins with
// w0.
Vec3 midpoint_spin(const Mat3& I, Vec3 w0, double h) {
  Vec3 w = w0, L0 = I * w0;
  for (int it = 0; it < 20; it++) {
    Vec3 Lw = I * w, f = 2.0 * (Lw - L0) + h * cross(w, Lw);
    if (norm2(f) <= 1e-32 * (norm2(L0) + 1e-300)) break;
    Mat3 D;
    for (int j = 0; j < 3; j++) {
      Vec3 e;
      e[j] = 1;
      Vec3 Ie = I.col(j), c = 2.0 * Ie + h * (cross(e, Lw) + cross(w, Ie));
      for (int i = 0; i < 3; i++) D.m[3 * i + j] = c[i];
    }
    w -= solve3(D, f);
  }
  return w;
}

}  // namespace

void object_velocity(const System& system, const State& state, Step& step, double h,
                     const std::vector<char>* only) {
  const Model& model = system.model;
  const World& world = system.world;
  for (int b : system.objects) {
    if (!world.active[b] || model.held[b] || world.asleep[b] || (only && !(*only)[b])) continue;
    int d = model.dof_first[b];
    Vec3 v = load3(&state.qvel[d]) + h * system.gravity, w0 = load3(&state.qvel[d + 3]);
    Mat3 R = to_matrix(model.iquat[b]), I;
    for (int i = 0; i < 3; i++)
      for (int j = 0; j < 3; j++) {
        I.m[3 * i + j] = 0;
        for (int a = 0; a < 3; a++)
          I.m[3 * i + j] += R.m[3 * i + a] * model.inertia[b][a] * R.m[3 * j + a];
      }
    const Vec3 w = midpoint_spin(I, w0, h);
    store3(&step.v_free[d], v);
    store3(&step.v_free[d + 3], w);
    store3(&step.spin[d + 3], w - w0);
  }
}

}  // namespace hp
