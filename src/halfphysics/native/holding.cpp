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

#include "stepper.h"

namespace hp {

namespace {

constexpr double kRest = 1e-9;  // smaller changes of velocity are rounding [m/s, rad/s]
constexpr double kOver = 1 + 1e-9;
// Joints join those that give way one by one, and leave them again: so often at most, per joint.
constexpr int kRounds = 3;

// Solves A x = b in place by Cholesky; A (n x n) is symmetric and positive definite.
void solve_dense(std::vector<double>& A, int n, std::vector<double>& x) {
  for (int i = 0; i < n; i++)
    for (int j = 0; j <= i; j++) {
      double s = A[i * n + j];
      for (int k = 0; k < j; k++) s -= A[i * n + k] * A[j * n + k];
      A[i * n + j] = i == j ? std::sqrt(s) : s / A[j * n + j];
    }
  for (int i = 0; i < n; i++) {
    for (int k = 0; k < i; k++) x[i] -= A[i * n + k] * x[k];
    x[i] /= A[i * n + i];
  }
  for (int i = n; i-- > 0;) {
    for (int k = i + 1; k < n; k++) x[i] -= A[k * n + i] * x[k];
    x[i] /= A[i * n + i];
  }
}

}  // namespace

void Stepper::find_carried() {
  carried_.assign(model.nbody, 0);
  for (int b = 1; b < model.nbody; b++)
    if (is_person(b) && model.dof_count[b] == 0) carried_[b] = carried_[model.root[b]] = 1;
}

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

void Stepper::find_load(double h) {
  for (const Drive& d : drives_) {
    const int root = d.body(0);
    if (!carries(d) || !world.active[root]) continue;
    std::vector<char> massive = carried_;
    massive[root] = 0;
    std::vector<double> asked(model.nv, 0), change(model.nv, 0), now(model.nv, 0), off(model.nv, 0);
    d.reference(asked.data());
    d.reference_change(change.data());
    std::vector<int> bodies;
    for (int b = root; b < model.nbody && model.root[b] == root; b++) bodies.push_back(b);
    bias_forces(model, start_.kin, asked.data(), gravity, bodies, load_.data(), change.data(), &massive);
    d.unhindered(now.data());
    double most = 0;
    for (int i = d.first_dof(); i < d.first_dof() + d.dof_count(); i++) {
      off[i] = now[i] - asked[i];
      most = std::max(most, std::fabs(off[i]));
    }
    if (most < kRest) continue;
    add_drift(d, h, now, off, 1);
    add_drift(d, h, asked, std::vector<double>(model.nv, 0), -1);
  }
}

// Adds to load_ what keeping joint velocities took in the substep before: the change of momentum from its
// start to its end. Velocities `held` move what is held, `own` the person's bodies. With it what gives way
// keeps the momentum that it had, as far as the joints let it: its energy does not grow. The joints'
// velocities alone, or their Coriolis forces taken at one pose, would gain some, and heavy things run away.
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
    if (carries(d) && world.active[d.body(0)] && !d.limits.empty() && !d.gentle()) bear(d, h);
}

// Without contact a substep changes the deviation of velocity by x, M x = u - h load, u what the drive exerts.
// It wants the x that v_free_ has. A joint that this would take more than it may exerts as much as it may,
// in the same direction, and gives way; what that leaves the others to do is less or more than before. Those
// that would be driven beyond what they want hold after all.
void Stepper::bear(const Drive& d, double h) {
  const int first = d.first_dof(), end = first + d.dof_count(), count = d.ball_count() + 1;
  std::vector<double> x(model.nv, 0), wanted(model.nv, 0), u(model.nv, 0);
  d.unhindered(wanted.data());
  double most = 0;
  for (int i = first; i < end; i++) {
    wanted[i] = v_free_[i] - wanted[i];
    most = std::max(most, std::fabs(wanted[i]));
  }
  x = wanted;
  auto needed = [&] {  // to change by x
    std::fill(u.begin(), u.end(), 0.0);
    if (most >= kRest) weigh(d, x.data(), 1, nullptr, u.data());
    for (int i = first; i < end; i++) u[i] += h * load_[i];
  };
  std::vector<double> may(count), exerted(model.nv, 0);
  for (int k = 0; k < count; k++) may[k] = d.allowance(k, h);
  std::vector<char> gives(count, 0);
  if (most >= kRest) build_inertia(h);
  bool any = false;
  for (int round = 0; round < kRounds * count; round++) {
    needed();
    int worst = -1;
    double over = kOver;
    for (int k = 0; k < count; k++) {
      const double size = norm(load3(&u[d.limit_dof(k)]));
      if (gives[k] || size <= over * may[k] || size == 0) continue;
      worst = k;
      if (may[k] == 0) break;
      over = size / may[k];
    }
    if (worst >= 0) {
      if (!any) build_inertia(h);
      any = true;
      most = kRest;  // M takes part from now on
      gives[worst] = 1;
      const int at = d.limit_dof(worst);
      const Vec3 all = load3(&u[at]);
      store3(&exerted[at], (may[worst] / norm(all)) * all);
    } else {
      bool back = false;
      for (int k = 0; k < count; k++) {
        const int at = d.limit_dof(k);
        if (!gives[k] || dot(load3(&x[at]) - load3(&wanted[at]), load3(&exerted[at])) <= 0) continue;
        gives[k] = 0, back = true;
      }
      if (!back) break;
    }
    // Who gives way moves as the rest of them, and those who hold, let it.
    std::vector<int> dofs, row(model.nv, -1);
    x = wanted;
    for (int k = 0; k < count; k++)
      for (int c = 0; c < 3 && gives[k]; c++) {
        const int i = d.limit_dof(k) + c;
        row[i] = (int)dofs.size();
        dofs.push_back(i);
        x[i] = 0;
      }
    needed();
    const int n = (int)dofs.size();
    std::vector<double> A((size_t)n * n, 0), b(n);
    for (int r = 0; r < n; r++) {
      const int i = dofs[r];
      b[r] = exerted[i] - u[i];
      const double* m = &inertia_.M[model.row_start[i]];
      const int* dof = &model.chain[model.row_start[i]];
      for (int a = 0; a < model.row_size[i]; a++)
        if (row[dof[a]] >= 0) A[(size_t)r * n + row[dof[a]]] = A[(size_t)row[dof[a]] * n + r] = m[a];
    }
    solve_dense(A, n, b);
    for (int r = 0; r < n; r++) x[dofs[r]] = b[r];
  }
  if (!any) return;
  disturbed_[d.body(0)] = 1;
  d.unhindered(v_free_.data());
  for (int i = first; i < end; i++) v_free_[i] += x[i];
}

}  // namespace hp
