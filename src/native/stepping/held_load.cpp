#include "stepping/held_load.h"

#include <algorithm>

#include "tuning.h"

namespace hp {

namespace tune = tuning::stepping;

namespace {

// The momentum of a body about its centre of mass.
struct Momentum {
  Vec3 centre, linear, angular;
};

Momentum momentum_of(const Model& m, const Kinematics& k, const std::vector<Twist>& twists, int b) {
  const Vec3 at = k.xpos[b] + k.xmat[b] * m.ipos[b];
  const Mat3 R = k.xmat[b] * to_matrix(m.iquat[b]);
  const Vec3 w = mul_t(R, twists[b].w);
  const Vec3 own{m.inertia[b].x * w.x, m.inertia[b].y * w.y, m.inertia[b].z * w.z};
  return {at, m.mass[b] * (twists[b].v + cross(twists[b].w, at - k.reference(m, b))), R * own};
}

}  // namespace

void HeldLoad::find(const System& system, const State& state, double h) {
  const Model& model = system.model;
  const std::vector<double> still(model.nv, 0);
  for (const Drive& d : system.drives) {
    const int root = d.body(0);
    if (!system.carries(d) || !system.world.active[root]) continue;
    std::vector<char> massive = system.holds_load;
    massive[root] = 0;
    std::vector<double> asked(still), change(still), now(still);
    d.reference(asked.data());
    d.reference_change(change.data());
    d.unhindered(now.data());
    double most = 0;
    for (int i = d.first_dof(); i < d.first_dof() + d.dof_count(); i++)
      most = std::max(most, std::fabs(now[i] - asked[i]));
    const bool follows = most < tune::kVelocityRounding;
    std::vector<int> bodies;
    for (int b = root; b < model.nbody && model.root[b] == root; b++) bodies.push_back(b);
    bias_forces(model, state.pose.kin, follows ? asked.data() : still.data(), system.gravity,
                bodies, load_.data(), change.data(), &massive);
    if (follows) continue;
    add_drift(system, state, d, h, now, now, 1);
    // Following the motion costs the person nothing.
    add_drift(system, state, d, h, still, asked, -1);
  }
}

// Adds to the load, times `sign`, what keeping the joints' velocities took in the substep before:
// the change of momentum from its start to its end. Velocities `held` move held objects, `own` the
// person's bodies. With it joints that give way keep the momentum that they had, as far as the
// joints let it: energy does not grow. The joints' velocities alone, or their Coriolis forces taken
// at one pose, would gain some, and heavy objects run away.
void HeldLoad::add_drift(const System& system, const State& state, const Drive& d, double h,
                         const std::vector<double>& held, const std::vector<double>& own,
                         double sign) {
  const Model& model = system.model;
  const Kinematics& after = state.pose.kin;
  const char* active = system.world.active.data();
  std::vector<double> q = state.qpos, v(model.nv, 0);
  d.unhindered(v.data());
  integrate(model, q.data(), v.data(), -h, active);
  Kinematics before;
  before.resize(model);
  before.update(model, q.data(), active);
  before.update_dofs(model, q.data(), active);
  std::vector<Twist> of_held[2], of_own[2];
  const Kinematics* at[2] = {&before, &after};
  for (int i = 0; i < 2; i++) {
    body_twists(model, *at[i], held.data(), of_held[i]);
    body_twists(model, *at[i], own.data(), of_own[i]);
  }
  std::vector<Twist> force(model.nbody);
  const int root = d.body(0);
  int last = root;
  for (int b = root; b < model.nbody && model.root[b] == root; b++) {
    const auto& twists = system.holds_load[b] && b != root ? of_held : of_own;
    const Momentum p = momentum_of(model, before, twists[0], b),
                   now = momentum_of(model, after, twists[1], b);
    const Vec3 push = (sign / h) * (now.linear - p.linear);
    force[b] = {(sign / h) * (now.angular - p.angular) +
                    cross(now.centre - after.reference(model, b), push),
                push};
    last = b;
  }
  for (int b = last; b >= root; b--) {
    for (int i = model.dof_first[b]; i < model.dof_first[b] + model.dof_count[b]; i++)
      load_[i] += dot(after.cdof[i].w, force[b].w) + dot(after.cdof[i].v, force[b].v);
    if (b == root) break;
    force[model.parent[b]].w += force[b].w;
    force[model.parent[b]].v += force[b].v;
  }
}

void HeldLoad::bear(System& system, Data& data, double h) const {
  for (const Drive& d : system.drives)
    if (system.active(d) && !d.limits.empty() && !d.gentle()) bear(system, data, d, h);
}

namespace {

// y, by which a person's joints give way: `need` [nv] is the impulse that following takes, may[k]
// the one that joint k has.
std::vector<double> yield(const System& system, const Inertia& inertia, const Drive& d,
                          const std::vector<double>& need, const std::vector<double>& may) {
  const Model& model = system.model;
  const int first = d.first_dof(), end = first + d.dof_count(), count = (int)may.size();
  const std::vector<double> whole(model.nv, 1);
  std::vector<double> resistance(model.nv, 0), y, rate(count, tune::kLeastYieldRate);
  InertiaFactor body;
  for (int round = 0; round < tune::kYieldRounds + tune::kSafeYieldRounds; round++) {
    const bool late = round >= tune::kYieldRounds;  // joints only give way more
    for (int k = 0; k < count; k++)
      std::fill_n(&resistance[d.limit_dof(k)], 3,
                  std::min(tune::kRigidResistance, may[k] / rate[k]));
    body.factor(model, inertia, whole, resistance, system.world.active.data());
    y.assign(model.nv, 0);
    for (int i = first; i < end; i++) y[i] = -need[i];
    body.solve(model, y.data());
    bool good = true;
    for (int k = 0; k < count; k++) {
      const double share = norm(load3(&y[d.limit_dof(k)])) / rate[k];  // of the limit
      if (may[k] == 0 || may[k] / rate[k] >= tune::kRigidResistance ||
          (rate[k] == tune::kLeastYieldRate && share <= 1))
        continue;
      const double over = share - 1;
      if (late && over <= tune::kYieldTolerance) continue;
      good &= std::fabs(over) <= tune::kYieldTolerance;
      rate[k] = std::max(tune::kLeastYieldRate,
                         rate[k] * elementary::pow(share, tune::kYieldOverRelaxation));
    }
    if (good) break;
  }
  return y;
}

}  // namespace

void HeldLoad::bear(System& system, Data& data, const Drive& d, double h) const {
  const Model& model = system.model;
  std::vector<double>& v_free = data.step.v_free;
  const int first = d.first_dof(), end = first + d.dof_count(), count = d.ball_count() + 1;
  std::vector<double> wanted(model.nv, 0), need(model.nv, 0);
  d.unhindered(wanted.data());
  double most = 0;
  for (int i = first; i < end; i++) {
    wanted[i] = v_free[i] - wanted[i];
    most = std::max(most, std::fabs(wanted[i]));
  }
  if (most >= tune::kVelocityRounding) {
    data.inertia.add_up(system, data.state, data.step, h);
    data.inertia.multiply(system, d, wanted.data(), need.data());
  }
  for (int i = first; i < end; i++) need[i] += h * load_[i];
  std::vector<double> may(count);
  bool enough = true;
  for (int k = 0; k < count; k++) {
    // Up it is held by what it stands on, down it is pulled by its weight.
    const bool root = k == 0 && d.root_force.on;
    const double most = root ? d.root_force.upright(need[first + 2]) : d.limits[k];
    may[k] = h * most / (1 + tune::kYieldTolerance);
    enough &= norm(load3(&need[d.limit_dof(k)])) <=
              may[k] + tune::kVelocityRounding * tune::kVelocityRounding;
  }
  if (enough) return;
  data.inertia.add_up(system, data.state, data.step, h);
  const std::vector<double> y = yield(system, data.inertia.inertia(), d, need, may);
  data.result.disturbed[d.body(0)] = 1;
  d.unhindered(v_free.data());
  for (int i = first; i < end; i++) v_free[i] += wanted[i] + y[i];
}

}  // namespace hp
