#include "stepper.h"

#include <chrono>
#include <cstring>
#include <limits>
#include <numeric>
#include <stdexcept>

namespace hp {

namespace {

constexpr int kPasses = 8;         // solve and verify, at most
// What is stepped through may stray this far from what it would do by itself before those who
// follow their motion are asked again [m].
constexpr double kStray = 0.03;
constexpr double kSlackReach = 0.004;  // planes are asked for this much farther than needed [m]
constexpr double kBounceSpeed = 0.2;   // slower impacts do not bounce [m/s]
constexpr double kRounding = 1e-9;     // of distances after a substep, at any tolerance [m]
// A gap may miss what is asked of it by this share: curvature within a substep costs no more solves.
constexpr double kSlack = 0.02;
// Solving is bounded, and what is left to settle then shortens the step: multiplications of a
// substep, and contact points.
constexpr double kMostWork = 1e8;
constexpr size_t kMostContacts = 250;
constexpr double kWarmRadius2 = 0.02 * 0.02;

}  // namespace

void Stepper::finish(const std::vector<int>& person_roots) {
  model.finish();
  drives_.clear();
  std::vector<char> person(model.nbody, 0);
  for (int root : person_roots) {
    if (root <= 0 || root >= model.nbody) throw std::invalid_argument("bad root body");
    drives_.emplace_back(model, root);
    person[root] = 1;
  }
  objects_.clear();
  for (int b = 1; b < model.nbody; b++)
    if (!person[b] && model.jnt_count[b] == 1 &&
        model.jnt_type[model.jnt_first[b]] == Joint::Free)
      objects_.push_back(b);
  for (Mover& m : world.movers) {
    if (m.body <= 0 || m.body >= model.nbody) throw std::invalid_argument("bad body of a shape");
    m.shape.finish();
  }
  qpos_.assign(model.nq, 0);
  for (auto* v : {&qvel_, &v_free_, &v_, &spin_, &extra_, &torque_, &moved_})
    v->assign(model.nv, 0);
  scale_.assign(model.nv, 1);
  start_.kin.resize(model);
  end_.kin.resize(model);
}

void Stepper::reset(const double* qpos, const double* qvel) {
  qpos_.assign(qpos, qpos + model.nq);
  qvel_.assign(qvel, qvel + model.nv);
  for (Drive& d : drives_) d.reset(&qpos_[d.first_qpos()], qvel_.data());
  warm_.clear();
  touches_.clear();
  solve_times.clear();
  world.forget();
  pose_known_ = false;
  start_pose();
  world.reset(model, start_);
}

void Stepper::start_pose() {
  if (pose_known_) return;
  world.active.assign(model.nbody, 1);
  start_.kin.update(model, qpos_.data());
  world.start_poses(start_);
  pose_known_ = true;
}

const std::vector<double>& Stepper::qvel() {
  for (Drive& d : drives_) d.velocity(qvel_.data());
  return qvel_;
}

// How the parts of a person who follows the motion move. Joint rates are constant in the child's
// frame, so that angular velocities add up along the chain and turn with it: with W the sum of
// their bounds, B that of the turning, a point at r has speed <= V + W r and acceleration
// <= A + (W^2 + B) r, and stays within dt^2/8 times that of the line between its ends.
void Stepper::sweep_of(const Drive& d, double dt, const std::vector<char>& busy) {
  if (busy[d.body(0)]) return;
  Vec3 root;
  d.speeds(angular_, root);
  spin_bound_.resize(model.nbody);
  turn_bound_.resize(model.nbody);
  speed_bound_.resize(model.nbody);  // accelerations of the frames' origins
  for (size_t i = 0; i < angular_.size(); i++) {
    int b = d.body((int)i), p = model.parent[b];
    double w = angular_[i];
    if (i == 0) {
      spin_bound_[b] = w, turn_bound_[b] = 0, speed_bound_[b] = 0;
      continue;
    }
    double arm = norm(model.pos[b]);
    spin_bound_[b] = spin_bound_[p] + w;
    turn_bound_[b] = turn_bound_[p] + spin_bound_[p] * w;
    speed_bound_[b] =
        speed_bound_[p] + (spin_bound_[p] * spin_bound_[p] + turn_bound_[p]) * arm;
  }
  for (size_t i = 0; i < world.movers.size(); i++) {
    const Mover& m = world.movers[i];
    if (model.root[m.body] != model.root[d.body(0)]) continue;
    int b = m.body;
    double reach = norm(m.shape.center) + m.shape.bound;
    double bulge = 0.125 * dt * dt *
                   (speed_bound_[b] + (spin_bound_[b] * spin_bound_[b] + turn_bound_[b]) * reach);
    const Quat &p = start_.kin.xquat[b], &q = end_.kin.xquat[b];
    double cosine = std::fabs(p.w * q.w + p.x * q.x + p.y * q.y + p.z * q.z);
    double sine = std::sqrt(std::max(0.0, 1 - cosine * cosine));
    Vec3 from = start_.kin.xpos[b] + start_.kin.xmat[b] * m.shape.center,
         to = end_.kin.xpos[b] + end_.kin.xmat[b] * m.shape.center;
    sweep_.bulge[i] = bulge;
    sweep_.way[i] = norm(to - from) + 2 * sine * m.shape.bound + bulge;
  }
}

// People who are where the motion has them and meet nothing on their whole way to its next frame
// need no steps: they arrive there.
void Stepper::find_busy(double dt, std::vector<char>& busy) {
  busy.assign(model.nbody, 1);
  q_free_ = qpos_;
  bool any = false;
  for (const Drive& d : drives_) {
    if (!d.settled(drive_settings, qpos_.data())) continue;
    busy[d.body(0)] = 0;
    d.follow(1, q_free_.data());
    any = true;
  }
  if (!any) return;
  world.active.assign(model.nbody, 0);
  for (int b = 1; b < model.nbody; b++) world.active[b] = !busy[model.root[b]];
  end_.kin.update(model, q_free_.data(), world.active.data());
  world.start_poses(end_);
  const size_t n = world.movers.size();
  sweep_.way.assign(n, 0);
  sweep_.bulge.assign(n, 0);
  assumed_.assign(n, 0);
  // Whoever is stepped through is assumed not to get much farther than it would by itself.
  bool stepped = false;
  for (size_t i = 0; i < n; i++) {
    int b = world.movers[i].body;
    if (!busy[model.root[b]]) continue;
    if (!stepped) {
      start_.kin.update_dofs(model, qpos_.data());
      body_twists(model, start_.kin, qvel().data(), twists_);
      stepped = true;
    }
    double fall = norm(gravity) * dt * dt;
    sweep_.way[i] = 1.5 * dt * speed_bound(world.movers[i], twists_) + fall + kStray;
    assumed_[i] = world.travelled((int)i) + sweep_.way[i];
  }
  for (const Drive& d : drives_) sweep_of(d, dt, busy);
  world.active.assign(model.nbody, 1);
  world.list(model, start_, sweep_.way);
  world.find_busy(model, start_, end_, sweep_, busy);
}

void Stepper::frame(const double* targets, double dt, int n, std::vector<double>* poses) {
  touches_.clear();
  diagnostics_ = {};
  disturbed_.assign(model.nbody, 0);
  start_pose();
  settled_.clear();
  for (Drive& d : drives_) {
    d.aim(drive_settings, targets, dt, qpos_.data());
    settled_.push_back(d.settled(drive_settings, qpos_.data()));
    targets += d.qpos_count();
  }
  const size_t first_row = poses ? poses->size() : 0;
  q_start_ = qpos_;
  find_busy(dt, busy_);
  bool any_busy = false, any_free = false;
  for (int b = 1; b < model.nbody; b++)
    if (model.root[b] == b) (busy_[b] ? any_busy : any_free) = true;
  if (any_busy && any_free) {
    followed_ = start_;
    std::vector<double> before = save();
    std::vector<Drive> drives = drives_;
    substeps(dt, n, poses);
    bool strayed = false;
    for (size_t i = 0; i < world.movers.size(); i++)
      strayed |= busy_[model.root[world.movers[i].body]] &&
                 world.travelled((int)i) > assumed_[i];
    if (strayed) {  // they got farther after all: again, step by step for everybody
      restore(before);
      drives_ = drives;
      world.forget();
      if (poses) poses->resize(first_row);
      diagnostics_ = {};
      touches_.clear();
      disturbed_.assign(model.nbody, 0);
      busy_.assign(model.nbody, 1);
      any_free = false;
      substeps(dt, n, poses);
    }
  } else if (any_busy) {
    substeps(dt, n, poses);
  } else if (poses) {
    for (int k = 0; k < n; k++) poses->insert(poses->end(), qpos_.begin(), qpos_.end());
  }
  // Whom nothing touched has arrived, stepped through or not: the same bits either way.
  for (size_t i = 0; i < drives_.size(); i++) {
    Drive& d = drives_[i];
    if (!settled_[i] || disturbed_[d.body(0)]) continue;
    const int first = d.first_qpos(), count = d.qpos_count();
    auto arrive = [&](double share, double* q) {
      std::copy_n(&q_start_[first], count, q + first);
      d.follow(share, q);
    };
    if (poses)
      for (int k = 0; k < n; k++)
        arrive((k + 1.0) / n, &(*poses)[first_row + (size_t)k * model.nq]);
    arrive(1, qpos_.data());
    d.followed();
  }
  if (!any_free) return;
  if (any_busy) {
    // Who followed has travelled too.
    for (int b = 1; b < model.nbody; b++) world.active[b] = !busy_[model.root[b]];
    end_.kin.update(model, qpos_.data());
    world.start_poses(end_);
    world.travel(followed_, end_);
  } else {
    world.travel(start_, end_);
  }
  std::swap(start_, end_);
  world.active.assign(model.nbody, 1);
}

void Stepper::substeps(double dt, int n, std::vector<double>* poses) {
  for (int b = 1; b < model.nbody; b++) world.active[b] = busy_[model.root[b]];
  for (Drive& d : drives_)
    if (busy_[d.body(0)]) d.begin_frame(drive_settings, qpos_.data(), qvel_.data());
  for (int k = 0; k < n; k++) {
    substep(k, dt / n);
    if (poses) poses->insert(poses->end(), qpos_.begin(), qpos_.end());
  }
}

void Stepper::build_inertia(double h) {
  if (inertia_ready_) return;
  inertia_.compose(model, start_.kin);
  std::fill(extra_.begin(), extra_.end(), 0.0);
  for (const Drive& d : drives_) {
    if (!world.active[d.body(0)]) continue;
    d.added_inertia(model, inertia_, drive_settings, extra_);
    double s = d.scale(drive_settings, h);
    std::fill_n(scale_.begin() + d.first_dof(), d.dof_count(), s);
  }
  inertia_.factor(model, scale_, extra_);
  inertia_ready_ = true;
}

// Gravity, and the free rotation by the implicit midpoint rule. The pose moves with the midpoint
// velocity; `spin_` keeps what is then missing to the velocity at the end of the substep.
void Stepper::object_velocity(double h) {
  for (int b : objects_) {
    if (!world.active[b]) continue;
    int d = model.dof_first[b];
    Vec3 v = load3(&qvel_[d]) + h * gravity, w0 = load3(&qvel_[d + 3]);
    Mat3 R = to_matrix(model.iquat[b]), I;
    for (int i = 0; i < 3; i++)
      for (int j = 0; j < 3; j++) {
        I.m[3 * i + j] = 0;
        for (int a = 0; a < 3; a++)
          I.m[3 * i + j] += R.m[3 * i + a] * model.inertia[b][a] * R.m[3 * j + a];
      }
    // Newton on  2 I (w - w0) + h w x I w = 0  for the midpoint velocity w.
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
    store3(&v_free_[d], v);
    store3(&v_free_[d + 3], w);
    store3(&spin_[d + 3], w - w0);
  }
}

void Stepper::free_velocity(int k, double h) {
  v_free_ = qvel_;
  std::fill(torque_.begin(), torque_.end(), 0.0);
  bool any = false;
  for (const Drive& d : drives_)
    if (world.active[d.body(0)])
      any |= d.free_velocity(drive_settings, k, h, qpos_.data(), qvel_.data(), v_free_.data(),
                             torque_.data());
  if (any) {
    build_inertia(h);
    for (int i = 0; i < model.nv; i++) torque_[i] *= extra_[i] / h;
    inertia_.solve(model, torque_.data());
    for (int i = 0; i < model.nv; i++) v_free_[i] += torque_[i];
  }
  object_velocity(h);
}

double Stepper::speed_bound(const Mover& m, const std::vector<Twist>& t) const {
  const Twist& w = t[m.body];
  Vec3 center = start_.kin.xpos[m.body] + start_.kin.xmat[m.body] * m.shape.center;
  Vec3 v = w.v + cross(w.w, center - start_.kin.reference(model, m.body));
  return norm(v) + norm(w.w) * m.shape.bound;
}

void Stepper::pose_at(const std::vector<double>& v, double h, Poses& out,
                      std::vector<double>& q) {
  q = qpos_;
  integrate(model, q.data(), v.data(), h, world.active.data());
  out.kin.update(model, q.data(), world.active.data());
  world.start_poses(out);
}

void Stepper::warm_start(Contact& c) {
  const Mover& m = world.movers[candidates_[c.pair].mover];
  Vec3 local = mul_t(start_.kin.xmat[m.body], c.position - start_.kin.xpos[m.body]);
  double best = kWarmRadius2;
  Warm* found = nullptr;
  for (Warm& w : warm_) {
    if (w.key != c.key || dot(w.normal, c.n) < 0.8) continue;
    double d = norm2(w.local - local);
    if (d < best) best = d, found = &w;
  }
  if (!found) return;
  c.impulse = found->impulse;
  found->key = -1;  // used
}

void Stepper::remember() {
  warm_.clear();
  // Points found after the last solve only carry a guess.
  contacts_.resize(std::min(contacts_.size(), solved_));
  for (const Contact& c : contacts_) {
    if (norm2(c.impulse) == 0) continue;
    const Candidate& k = candidates_[c.pair];
    disturbed_[model.root[world.movers[k.mover].body]] = 1;
    if (k.other_mover >= 0) disturbed_[model.root[world.movers[k.other_mover].body]] = 1;
    const Mover& m = world.movers[k.mover];
    Vec3 local = mul_t(start_.kin.xmat[m.body], c.position - start_.kin.xpos[m.body]);
    warm_.push_back({c.key, c.feature, local, c.n, c.impulse});
    Touch* t = nullptr;
    for (Touch& o : touches_)
      if (o.mover == k.mover && o.other_static == k.other_static &&
          o.other_mover == k.other_mover && dot(o.normal, c.n) > 0.95 * norm(o.normal))
        t = &o;
    if (!t) {
      touches_.push_back({k.mover, k.other_static, k.other_mover, {}, {}, {}, 0});
      t = &touches_.back();
    }
    double p = dot(c.impulse, c.n);
    t->position += p * c.position;
    t->normal += p * c.n;
    t->impulse += c.impulse;
    t->weight += p;
  }
}

double Stepper::excess(size_t i, double h) {
  double e = world.excess(start_, end_, candidates_[i]);
  if (candidates_[i].forgiven && candidates_[i].triangle >= 0 && !candidates_[i].searched)
    world.search_behind(start_, reach_, h, (int)i, candidates_);
  return e;
}

// Checks the end pose against every candidate; adds contact points where something is violated
// and corrects the linear prediction of those there are. True if all is well.
bool Stepper::verify(double h, int pass, double& worst) {
  worst = 0;
  bool good = true;
  body_twists(model, start_.kin, v_.data(), twists_);
  std::vector<char> violated;
  for (size_t i = 0; i < candidates_.size(); i++) {  // forgiven planes add to them
    double e = excess(i, h), allowed = 2 * world.settings.tolerance + kRounding;
    worst = std::min(worst, e);
    if (candidates_[i].target > 0) allowed += kSlack * candidates_[i].target;
    violated.push_back(e < -allowed);
    good &= !violated.back();
  }
  if (good) return true;
  size_t old = contacts_.size();
  for (size_t i = 0; i < candidates_.size(); i++)
    if (violated[i] && contacts_.size() < kMostContacts)
      world.add_contacts(model, start_, end_, candidates_[i], (int)i, pass, contacts_);
  for (size_t i = 0; i < contacts_.size(); i++) {
    Contact& c = contacts_[i];
    if (pass > 0) {
      Vec3 u = endpoint_velocity(model, start_.kin, twists_, c.a) -
               endpoint_velocity(model, start_.kin, twists_, c.b);
      c.shift = c.dist + h * dot(c.n, u) - world.gap_at(start_, end_, c);
    }
    if (i >= old) warm_start(c);
  }
  return false;
}

// Where all demands cannot be met, the clearance gives way before the step does.
void Stepper::give_way() {
  for (Candidate& c : candidates_)
    c.target = std::min(c.target, c.dist >= 0 ? std::min(c.dist, 1e-4) : c.dist);
  for (Contact& c : contacts_) c.target = candidates_[c.pair].target;
}

// What is still violated shortens the step of everything connected to it. Fills moved_ with the
// velocity scaled by each island's factor and returns the largest share of the step lost.
double Stepper::shorten(double h) {
  std::vector<int> island(model.nbody);
  std::iota(island.begin(), island.end(), 0);
  auto find = [&](int b) {
    while (island[b] != b) b = island[b] = island[island[b]];
    return b;
  };
  auto tree = [&](int mover) { return model.root[world.movers[mover].body]; };
  for (const Candidate& c : candidates_)
    if (c.other_mover >= 0) island[find(tree(c.mover))] = find(tree(c.other_mover));
  std::vector<double> good(model.nbody, 0), bad(model.nbody, 1), at(model.nbody, 1);
  std::vector<char> hurt(model.nbody, 0);
  auto check = [&]() {
    std::vector<char> ok(model.nbody, 1);
    for (size_t i = 0; i < candidates_.size(); i++)
      if (excess(i, h) + candidates_[i].target < candidates_[i].hard)
        ok[find(tree(candidates_[i].mover))] = 0;
    return ok;
  };
  auto move = [&]() {
    for (int i = 0; i < model.nv; i++)
      moved_[i] = v_[i] * at[find(model.root[model.dof_body[i]])];
    pose_at(moved_, h, end_, q_end_);
  };
  std::vector<char> ok = check();
  for (int b = 1; b < model.nbody; b++) hurt[b] = !ok[find(model.root[b])];
  for (int it = 0; it < 6; it++) {
    for (int b = 1; b < model.nbody; b++)
      if (hurt[b]) at[b] = 0.5 * (good[b] + bad[b]);
    move();
    ok = check();
    for (int b = 1; b < model.nbody; b++)
      if (hurt[b]) (ok[find(model.root[b])] ? good[b] : bad[b]) = at[b];
  }
  double lost = 0;
  for (int b = 1; b < model.nbody; b++)
    if (hurt[b]) {
      at[b] = good[b], lost = std::max(lost, 1 - good[b]);
      disturbed_[model.root[b]] = 1;
    }
  move();
  return lost;
}

void Stepper::solve(double h) {
  const auto begin = std::chrono::steady_clock::now();
  build_inertia(h);
  SolveReport r = solver_.solve(model, start_.kin, inertia_, h, v_free_.data(), v_.data(),
                                contacts_, world.settings.tolerance / h, world.settings.max_sweeps);
  diagnostics_.sweeps += r.sweeps;
  diagnostics_.passes++;
  double n3 = 3.0 * contacts_.size();
  work_ += n3 * n3 * (model.nv + r.sweeps);
  solved_ = contacts_.size();
  if (keep_trace) trace.contacts = contacts_;
  if (keep_times)
    solve_times.back() +=
        std::chrono::duration<double>(std::chrono::steady_clock::now() - begin).count();
}

// Restitution of a pair that arrived fast enough: a second pass demands its rebound. True if all
// is well afterwards, `good` where nothing rebounds.
bool Stepper::bounce(double h, bool good, double& worst) {
  body_twists(model, start_.kin, v_free_.data(), twists_);
  // The rebound starts where the substep does, above the surface, and before gravity has acted: the
  // speed is that of the parabola which meets the surface and leaves it e times as fast. (On this
  // grid a parabola's own speed is half a substep's gravity from the velocity.)
  std::vector<double> before(v_free_);
  for (int b : objects_)
    for (int i = 0; i < 3; i++) before[model.dof_first[b] + i] -= h * gravity[i];
  // Nor is the velocity in mid-step what it ends with where things spin fast.
  for (int i = 0; i < model.nv; i++) before[i] += spin_[i];
  std::vector<Twist> arrived, spun;
  body_twists(model, start_.kin, spin_.data(), spun);
  body_twists(model, start_.kin, before.data(), arrived);
  auto approach = [&](const Contact& c, const std::vector<Twist>& t) {
    return dot(c.n, endpoint_velocity(model, start_.kin, t, c.a) -
                        endpoint_velocity(model, start_.kin, t, c.b));
  };
  bool any = false;
  for (Contact& c : contacts_) {
    if (c.restitution <= 0 || dot(c.impulse, c.n) <= 0) continue;
    double arriving = approach(c, arrived);
    if (arriving > -kBounceSpeed) continue;
    double turned = approach(c, spun);
    double pull = std::max(0.0, arriving - turned - approach(c, twists_));
    double height = 2 * pull * std::max(0.0, c.dist - c.target) / h;
    double met = arriving - 0.5 * pull;
    double back = c.restitution * c.restitution * (met * met + height) - height;
    c.bounce = std::sqrt(std::max(0.0, back)) - 0.5 * pull - turned;
    any = true;
  }
  if (!any) return good;
  for (int pass = 1; pass < 4; pass++) {
    solve(h);
    pose_at(v_, h, end_, q_end_);
    if (verify(h, pass, worst)) return true;
  }
  return false;
}

void Stepper::substep(int k, double h) {
  inertia_ready_ = false;
  if (keep_times) solve_times.push_back(0);
  // Twists need the dofs' axes.
  start_.kin.update_dofs(model, qpos_.data(), world.active.data());
  free_velocity(k, h);
  v_ = v_free_;
  contacts_.clear();
  solved_ = 0;
  work_ = 0;

  const double clear = world.settings.clearance;
  body_twists(model, start_.kin, v_.data(), twists_);
  reach_.resize(world.movers.size());
  fastest_.assign(model.nbody, 0);
  for (size_t i = 0; i < reach_.size(); i++) {
    reach_[i] = 0;
    const int b = world.movers[i].body;
    if (!world.active[b]) continue;
    reach_[i] = h * speed_bound(world.movers[i], twists_);
    fastest_[model.root[b]] = std::max(fastest_[model.root[b]], reach_[i]);
  }
  // A contact can speed up what is slow now: a share of the fastest part's way for everyone.
  for (size_t i = 0; i < reach_.size(); i++) {
    const int b = world.movers[i].body;
    if (world.active[b])
      reach_[i] = 1.25 * std::max(reach_[i], 0.35 * fastest_[model.root[b]]) + clear + kSlackReach;
  }

  double worst = 0;
  bool good = true;
  for (int query = 0; query < 4; query++) {
    world.list(model, start_, reach_);
    world.gather(model, start_, reach_, h, candidates_);
    if (candidates_.empty()) break;
    diagnostics_.candidates = std::max(diagnostics_.candidates, (int)candidates_.size());
    contacts_.clear();
    v_ = v_free_;
    pose_at(v_, h, end_, q_end_);
    good = verify(h, 0, worst);
    bool gave_way = false;
    for (int pass = 1; !good; pass++) {
      if (pass > kPasses || work_ > kMostWork) {
        if (gave_way) break;
        gave_way = true;
        give_way();
        pass = 1;
      }
      solve(h);
      pose_at(v_, h, end_, q_end_);
      good = verify(h, pass, worst);
    }
    if (contacts_.empty()) break;
    good = bounce(h, good, worst);
    // Planes hold only for what was asked: ask again, from the start pose, for what moved more.
    body_twists(model, start_.kin, v_.data(), twists_);
    bool beyond = false;
    for (size_t i = 0; i < reach_.size(); i++) {
      if (!world.active[world.movers[i].body]) continue;
      double way = h * speed_bound(world.movers[i], twists_) + clear;
      if (way > reach_[i]) reach_[i] = 1.25 * way + kSlackReach, beyond = true;
    }
    if (!beyond) break;
  }
  if (candidates_.empty()) {
    contacts_.clear();
    pose_at(v_, h, end_, q_end_);
  }
  double lost = 0;
  if (!good) {
    bool hard = false;
    for (size_t i = 0; i < candidates_.size(); i++)
      hard |= excess(i, h) + candidates_[i].target < candidates_[i].hard;
    if (hard) {
      lost = shorten(h);
      diagnostics_.shortened++;
      diagnostics_.lost_time += lost * h;
    }
  }
  diagnostics_.residual = std::max(diagnostics_.residual, -worst);
  diagnostics_.contacts = std::max(diagnostics_.contacts, (int)contacts_.size());
  remember();
  if (keep_trace) {
    trace.qpos = qpos_, trace.qvel = qvel_, trace.v_free = v_free_, trace.v = v_;
    if (contacts_.empty()) trace.contacts.clear();
    trace.h = h, trace.k = k;
  }
  world.travel(start_, end_);
  std::swap(start_, end_);
  qpos_ = q_end_;
  qvel_ = v_;
  for (int b : objects_)
    if (world.active[b])
      for (int i = 3; i < 6; i++) qvel_[model.dof_first[b] + i] += spin_[model.dof_first[b] + i];
  for (Drive& d : drives_)
    if (world.active[d.body(0)]) d.end_substep(qvel_.data());
}

double Stepper::clearance() {
  start_pose();
  return world.clearance(model, start_, clearance_range);
}

std::vector<double> Stepper::save() {
  qvel();
  std::vector<double> out(qpos_);
  out.insert(out.end(), qvel_.begin(), qvel_.end());
  for (const Drive& d : drives_) d.save(out);
  world.save(out);
  out.push_back((double)warm_.size());
  for (const Warm& w : warm_) {
    out.insert(out.end(), {(double)(w.key >> 32), (double)(w.key & 0xffffffff), (double)w.feature});
    for (Vec3 v : {w.local, w.normal, w.impulse}) out.insert(out.end(), {v.x, v.y, v.z});
  }
  return out;
}

void Stepper::load(const std::vector<double>& state) {
  restore(state);
  world.forget();
  touches_.clear();
}

void Stepper::restore(const std::vector<double>& state) {
  pose_known_ = false;
  const double* in = state.data();
  std::copy(in, in + model.nq, qpos_.begin());
  in += model.nq;
  std::copy(in, in + model.nv, qvel_.begin());
  in += model.nv;
  for (Drive& d : drives_) in = d.load(in);
  in = world.load(in);
  warm_.clear();
  for (int n = (int)*in++; n > 0; n--, in += 12)
    warm_.push_back({((int64_t)in[0] << 32) | (int64_t)in[1], (int)in[2], load3(in + 3),
                     load3(in + 6), load3(in + 9)});
  start_pose();
}

}  // namespace hp
