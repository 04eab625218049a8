// What people hold: bodies of their tree that no joint moves.
//
// A person has neither weight nor inertia while doing what the motion says; what they hold has both. The
// generalised force that a held thing asks for, by being where the motion takes it, is that of inverse
// dynamics with the thing as the only mass:
//
//   load = M_held dv_ref/dt + (Coriolis, centrifugal, gravity)_held
//
// The drive bears it: who is strong enough follows the motion as if nothing were held. Where a joint is not,
// it exerts what it can and gives way. In everything else a held thing is a piece of its part.
#include <algorithm>

#include "stepping/stepper.h"

namespace hp {

namespace {

constexpr double kRest = 1e-9;  // smaller changes of velocity are rounding [m/s, rad/s]
// Joints give way no more slowly than this where another one gives way, too [rad/s]; what is exerted meets
// the limits to this share, in so many rounds. One that has none resists as if it had so much inertia more.
constexpr double kCreep = 1e-3, kShare = 0.02, kHold = 1e10;
constexpr int kRounds = 60;
constexpr double kStride = 1.5;  // over-relaxation, of logarithms
// What gives way turns no faster than that, or than the motion has it: a pitcher's shoulder, the fastest of
// human joints [rad/s].
constexpr double kFastest = 130;

// What a body has of momentum about its centre of mass.
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

void Stepper::find_carried() {
  carried_.assign(model.nbody, 0);
  for (int b = 1; b < model.nbody; b++)
    if (is_person(b) && model.dof_count[b] == 0) carried_[b] = carried_[model.root[b]] = 1;
}

void Stepper::find_load(double h) {
  const std::vector<double> still(model.nv, 0);
  for (const Drive& d : drives_) {
    const int root = d.body(0);
    if (!carries(d) || !world.active[root]) continue;
    std::vector<char> massive = carried_;
    massive[root] = 0;
    std::vector<double> asked(still), change(still), now(still);
    d.reference(asked.data());
    d.reference_change(change.data());
    d.unhindered(now.data());
    double most = 0;
    for (int i = d.first_dof(); i < d.first_dof() + d.dof_count(); i++)
      most = std::max(most, std::fabs(now[i] - asked[i]));
    const bool follows = most < kRest;
    std::vector<int> bodies;
    for (int b = root; b < model.nbody && model.root[b] == root; b++) bodies.push_back(b);
    bias_forces(model, start_.kin, follows ? asked.data() : still.data(), gravity, bodies, load_.data(),
                change.data(), &massive);
    if (follows) continue;
    add_drift(d, h, now, now, 1);
    add_drift(d, h, still, asked, -1);  // what the motion does with the person costs nothing
  }
}

// Adds to load_, times `sign`, what keeping the joints' velocities took in the substep before: the change of
// momentum from its start to its end. Velocities `held` move what is held, `own` the person's bodies. With
// it what gives way keeps the momentum that it had, as far as the joints let it: its energy does not grow.
// The joints' velocities alone, or their Coriolis forces taken at one pose, would gain some, and heavy things
// run away.
void Stepper::add_drift(const Drive& d, double h, const std::vector<double>& held,
                        const std::vector<double>& own, double sign) {
  std::vector<double> q = qpos_, v(model.nv, 0);
  d.unhindered(v.data());
  integrate(model, q.data(), v.data(), -h, world.active.data());
  Kinematics before;
  before.resize(model);
  before.update(model, q.data(), world.active.data());
  before.update_dofs(model, q.data(), world.active.data());
  std::vector<Twist> of_held[2], of_own[2];
  const Kinematics* at[2] = {&before, &start_.kin};
  for (int i = 0; i < 2; i++) {
    body_twists(model, *at[i], held.data(), of_held[i]);
    body_twists(model, *at[i], own.data(), of_own[i]);
  }
  std::vector<Twist> force(model.nbody);
  const int root = d.body(0);
  int last = root;
  for (int b = root; b < model.nbody && model.root[b] == root; b++) {
    const bool thing = carried_[b] && b != root;
    const auto& twists = thing ? of_held : of_own;
    const Momentum p = momentum_of(model, before, twists[0], b),
                   now = momentum_of(model, start_.kin, twists[1], b);
    const Vec3 push = (sign / h) * (now.linear - p.linear);
    force[b] = {(sign / h) * (now.angular - p.angular) +
                    cross(now.centre - start_.kin.reference(model, b), push),
                push};
    last = b;
  }
  for (int b = last; b >= root; b--) {
    for (int i = model.dof_first[b]; i < model.dof_first[b] + model.dof_count[b]; i++)
      load_[i] += dot(start_.kin.cdof[i].w, force[b].w) + dot(start_.kin.cdof[i].v, force[b].v);
    if (b == root) break;
    force[model.parent[b]].w += force[b].w;
    force[model.parent[b]].v += force[b].v;
  }
}

void Stepper::bear_load(double h) {
  for (const Drive& d : drives_)
    if (world.active[d.body(0)] && !d.limits.empty() && !d.gentle()) bear(d, h);
}

// Without contact a substep changes the deviation of velocity by x, M x = u - h load, u what the drive
// exerts. It wants the x that v_free_ has. Where that takes more than it may, joints give way by y,
// x = wanted + y, as dry friction does: u_j <= limit_j, and equal and against y_j where y_j is not zero. That
// is a convex problem, solved as a row of linear ones with resistances limit_j / |y_j| (iteratively
// reweighted).
void Stepper::bear(const Drive& d, double h) {
  const int first = d.first_dof(), end = first + d.dof_count(), count = d.ball_count() + 1;
  std::vector<double> wanted(model.nv, 0), need(model.nv, 0);
  d.unhindered(wanted.data());
  double most = 0;
  for (int i = first; i < end; i++) {
    wanted[i] = v_free_[i] - wanted[i];
    most = std::max(most, std::fabs(wanted[i]));
  }
  if (most >= kRest) {
    build_inertia(h);
    weigh(d, wanted.data(), need.data());
  }
  for (int i = first; i < end; i++) need[i] += h * load_[i];
  std::vector<double> may(count), rate(count, kCreep);
  bool enough = true;
  for (int k = 0; k < count; k++) {
    may[k] = h * d.limits[k] / (1 + kShare);
    enough &= norm(load3(&need[d.limit_dof(k)])) <= may[k] + kRest * kRest;
  }
  if (enough) return;
  build_inertia(h);
  const std::vector<double> whole(model.nv, 1);
  std::vector<double> resistance(model.nv, 0), y;
  Inertia body;
  body.M = inertia_.M;
  for (int round = 0; round < kRounds; round++) {
    for (int k = 0; k < count; k++)
      std::fill_n(&resistance[d.limit_dof(k)], 3, std::min(kHold, may[k] / rate[k]));
    body.factor(model, whole, resistance, world.active.data());
    y.assign(model.nv, 0);
    for (int i = first; i < end; i++) y[i] = -need[i];
    body.solve(model, y.data());
    bool good = true;
    for (int k = 0; k < count; k++) {
      const double share = norm(load3(&y[d.limit_dof(k)])) / rate[k];  // of the limit
      if (may[k] == 0 || may[k] / rate[k] >= kHold || (rate[k] == kCreep && share <= 1)) continue;
      good &= std::fabs(share - 1) <= kShare;
      rate[k] = std::max(kCreep, rate[k] * std::pow(share, kStride));
    }
    if (good) break;
  }
  disturbed_[d.body(0)] = 1;
  d.unhindered(v_free_.data());
  for (int i = first; i < end; i++) v_free_[i] += wanted[i] + y[i];
  std::vector<double> asked(model.nv, 0);
  d.reference(asked.data());
  for (int k = 1; k < count; k++) {
    const int at = d.limit_dof(k);
    const Vec3 w = load3(&v_free_[at]);
    const double fastest = std::max(kFastest, norm(load3(&asked[at])));
    if (norm(w) > fastest) store3(&v_free_[at], (fastest / norm(w)) * w);
  }
}

}  // namespace hp
