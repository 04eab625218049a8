// A substep: solve the contacts, verify the end pose, and what to do where that fails.
#include <chrono>
#include <numeric>

#include "stepping/stepper.h"

namespace hp {

namespace {

constexpr int kPasses = 8;   // solve and verify, at most, before the clearance gives way and after
// Solving stops when so many passes in a row have not halved the worst violation: a way that is too
// long to be straight gets no better, shorter ones do. Nor does a clearance that gives way cure what
// is violated by more than this many clearances. Points of things that miss less settle slowly.
constexpr int kStale = 2;
constexpr double kHopeless = 3, kSettling = 0.1;
constexpr int kQueries = 4;  // for planes with ever larger reach
constexpr double kSlackReach = 0.004;  // planes are asked for this much farther than needed [m]
constexpr double kBounceSpeed = 0.2;   // slower impacts do not bounce [m/s]
constexpr double kRounding = 1e-9;     // of distances after a substep, at any tolerance [m]
constexpr double kLeastMiss = 1e-13;   // the same, of who stands [m]
// A gap may miss what is asked of it by this share: curvature within a substep costs no more solves. By
// the second of these where one of the two is on a track.
constexpr double kSlack = 0.02, kWear = 0.1;
// Who leaves itself may miss this share of the way out that is asked; more than all of it, that is, get
// deeper by a quarter of it, once the clearance has given way.
constexpr double kLeisure = 0.5, kLeast = 1.25;
// Nobody is pushed apart faster than this for the sake of a curved way: a shorter step is straighter,
// and things that spin fast would gain energy [m/s].
constexpr double kPush = 3, kThingsPush = 0.05;
// What pulls harder than it moves is at first not thought to get farther than this, or than its own
// speed would take it by this factor [m].
constexpr double kFirstWay = 0.05, kFirstFactor = 2;
// Gaps that gave way this far are solved for more finely, by this factor: not to be worn away [m].
constexpr double kNarrow = 5e-5, kFiner = 0.1;
// Solving is bounded, and what is left to settle then shortens the step: multiplications of an
// attempt, those of a contact that takes part besides A itself, and contact points.
constexpr double kMostWork = 1e8, kRowWork = 60;
constexpr size_t kMostContacts = 250;
constexpr double kFar = 1e300;
constexpr double kWarmRadius2 = 0.02 * 0.02;

}  // namespace

double Stepper::speed_bound(const CollisionShape& m, const std::vector<Twist>& t) const {
  double fastest = m.most_of([&](const CollisionShape::Tie& tie) {
    const Twist& w = t[tie.body];
    const Vec3 at = start_.kin.xpos[tie.body] + start_.kin.xmat[tie.body] * tie.anchor;
    return norm(w.v + cross(w.w, at - start_.kin.reference(model, tie.body))) + norm(w.w) * tie.reach;
  });
  for (const CollisionShape::Stretch& s : m.stretches) {
    // The change of a rotation matrix is sqrt(2) times the angular velocity.
    const Skin& skin = *m.skin;
    fastest += std::sqrt(2.0) * s.most *
               norm(t[skin.body[s.joint]].w - t[skin.body[skin.parent[s.joint]]].w);
  }
  return fastest;
}

void Stepper::pose_at(const std::vector<double>& v, double h, Poses& out,
                      std::vector<double>& q) {
  q = qpos_;
  integrate(model, q.data(), v.data(), h, world.active.data());
  out.kin.update(model, q.data(), world.active.data());
  world.start_poses(out);
}

void Stepper::warm_start(Contact& c) {
  const int shape = candidates_[c.pair].shape;
  double best = kWarmRadius2;
  CachedContact* found = nullptr;
  for (CachedContact& w : warm_) {
    if (w.used || w.key != c.key || dot(w.normal, c.n) < 0.8) continue;
    double d = norm2(start_.position(world.shapes[shape], world.place(start_, shape), w.point) - c.position);
    if (d < best) best = d, found = &w;
  }
  if (!found) return;
  c.impulse = found->impulse;
  found->used = true;
  bend_way(c);  // it lasts
}

// The trees that planes connect: island_[tree].
void Stepper::find_islands() {
  island_.resize(model.nbody);
  std::iota(island_.begin(), island_.end(), 0);
  auto find = [&](int b) {
    while (island_[b] != b) b = island_[b] = island_[island_[b]];
    return b;
  };
  for (const ContactCandidate& c : candidates_) {
    if (c.other_shape < 0) continue;
    int a = tree(c.shape), b = tree(c.other_shape);
    if (world.active[a] && world.active[b]) island_[find(a)] = find(b);
  }
  for (int b = 0; b < model.nbody; b++) island_[b] = find(b);
}

int Stepper::island(const ContactCandidate& c) const {
  int a = tree(c.shape);
  return island_[world.active[a] ? a : tree(c.other_shape)];
}

// The contacts of trees that have made a step, whole or shortened.
void Stepper::remember(const std::vector<double>& share) {
  for (size_t i = next_warm_.size(); i-- > 0;) {
    // Who steps once more has new ones.
    const CollisionShape& m = world.shapes[next_warm_[i].key >> 32];
    if (world.active[m.body]) next_warm_.erase(next_warm_.begin() + i);
  }
  // Points found after the last solve only carry a guess.
  contacts_.resize(std::min(contacts_.size(), solved_));
  for (const Contact& c : contacts_) {
    if (norm2(c.impulse) == 0) continue;
    const ContactCandidate& k = candidates_[c.pair];
    if (!share.empty() && share[island(k)] < 0) continue;
    disturbed_[tree(k.shape)] = 1;
    if (k.other_shape >= 0) disturbed_[tree(k.other_shape)] = 1;
    for_touched(k, [&](int b) { pushed_now_[b] = 1; });
    auto material = [&](int shape, Vec3 x) -> Material {
      if (world.shapes[shape].skin && k.other_static >= 0) return c.gap_a;  // a vertex
      return start_.material(world.shapes[shape], world.place(start_, shape), x);
    };
    // Of two that move: the points that face each other, `dist` apart about the one they act on.
    const Vec3 half = k.other_shape >= 0 ? 0.5 * c.dist * c.n : Vec3{};
    Material other;
    if (k.other_shape >= 0) other = material(k.other_shape, c.position - half);
    next_warm_.push_back(
        {c.key, c.feature, material(k.shape, c.position + half), other, c.n, c.impulse, false});
    Touch* t = nullptr;
    for (Touch& o : touches_)
      if (o.shape == k.shape && o.other_static == k.other_static &&
          o.other_shape == k.other_shape && dot(o.normal, c.n) > 0.95 * norm(o.normal))
        t = &o;
    if (!t) {
      touches_.push_back({k.shape, k.other_static, k.other_shape, {}, {}, {}, 0});
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
  if (candidates_[i].forgiven && candidates_[i].triangle >= 0 && !candidates_[i].searched &&
      !world.mesh_clear(candidates_[i], start_, end_))
    world.search_behind(start_, reach_, h, (int)i, candidates_);
  return e;
}

// What a candidate's gap may miss of its target.
double Stepper::allowed(const ContactCandidate& c) const {
  double miss = 2 * tolerance_ + kRounding;
  // Who leaves itself need not do so at an exact speed.
  if (leaves_itself(c))
    return std::max(miss, (gave_way_[tree(c.shape)] ? kLeast : kLeisure) * (c.target - c.dist));
  // Nor need what leaves somebody whose pose is set.
  if (world.forced && c.dist < 0 && world.handles(c)) miss += kSlack * (c.target - c.dist);
  if (c.target > 0) miss += kSlack * c.target;
  // What nothing stops must not wear a gap away either.
  auto held = [&](int shape) { return shape >= 0 && model.held[world.shapes[shape].body]; };
  if (c.target >= 0 && (held(c.shape) || held(c.other_shape)))
    miss = std::min(miss, kWear * c.target + kRounding);
  // Nor may many small steps wear away the last of it.
  if (c.dist > 0 && c.hard > 0.5 * c.dist)
    miss = std::min(miss, std::max(0.0, c.target - c.hard) + kLeastMiss);
  return miss;
}

// Checks the end pose against every candidate; adds contact points where something is violated
// and corrects the linear prediction of those there are. True if all is well.
bool Stepper::verify(double h, int pass, double& worst) {
  worst = 0;
  bool good = true;
  body_twists(model, start_.kin, v_.data(), twists_);
  violated_.clear();
  overdue_ = 0;
  // Things that lie on each other pass on what they carry, a pair more in every pass: of them only
  // points count that were solved for.
  auto of_things = [&](const ContactCandidate& c) {
    return !is_person(world.shapes[c.shape].body) ||
           (c.other_shape >= 0 && !is_person(world.shapes[c.other_shape].body));
  };
  // Where there is a first solve anyhow, what hands may touch is looked at after it, not before it too.
  const bool begins = pass == 0 && world.recall(warm_, candidates_, recalled_);
  for (size_t i = 0; i < candidates_.size(); i++) {  // forgiven planes add to them
    if (begins && world.handles(candidates_[i])) {
      violated_.push_back(recalled_[i]);
      good &= !recalled_[i];
      continue;
    }
    double e = excess(i, h);
    worst = std::min(worst, e);
    violated_.push_back(e < -allowed(candidates_[i]));
    good &= !violated_.back();
    if (violated_.back() && !of_things(candidates_[i])) overdue_ = std::max(overdue_, -e);
  }
  if (good) return true;
  for (const Contact& c : contacts_)
    if (violated_[c.pair] && of_things(candidates_[c.pair])) {
      double miss = c.target - world.gap_at(start_, end_, c);
      if (miss > kSettling * world.settings.clearance) overdue_ = std::max(overdue_, miss);
    }
  if (contacts_.size() > kMostContacts) drop_idle();
  size_t old = contacts_.size();
  for (size_t i = 0; i < candidates_.size(); i++)
    if (violated_[i])
      world.add_contacts(warm_, start_, end_, candidates_[i], (int)i, pass, contacts_);
  for (size_t i = 0; i < contacts_.size(); i++) {
    Contact& c = contacts_[i];
    if (pass > 0) {
      const bool thing = !is_person(world.shapes[candidates_[c.pair].shape].body);
      c.shift = std::min(c.dist + h * approach(c, twists_, v_) - world.gap_at(start_, end_, c),
                         std::max(0.0, c.dist - c.target) + h * (thing ? kThingsPush : kPush));
    }
    if (i >= old) warm_start(c);
  }
  return false;
}

double Stepper::approach(const Contact& c, const std::vector<Twist>& twists,
                         const std::vector<double>& v) const {
  return dot(c.n, endpoint_velocity(model, start_.kin, twists, v.data(), c.a) -
                      endpoint_velocity(model, start_.kin, twists, v.data(), c.b));
}

// Points that carry nothing and would end where they may make room for those that are needed.
void Stepper::drop_idle() {
  size_t kept = 0;
  for (Contact& c : contacts_)
    if (norm2(c.impulse) > 0 || world.gap_at(start_, end_, c) < c.target) contacts_[kept++] = c;
  contacts_.resize(kept);
}

// Where the demands on an island cannot be met all together, its clearance gives way before its
// step does. False if everything that is violated has given way already.
bool Stepper::give_way() {
  find_islands();
  std::vector<char> now(model.nbody, 0);
  bool any = false;
  for (size_t i = 0; i < candidates_.size(); i++) {
    int b = island(candidates_[i]);
    if (i < violated_.size() && violated_[i] && !gave_way_[b]) now[b] = 1, any = true;
  }
  if (!any) return false;
  for (int b = 1; b < model.nbody; b++)
    if (now[island_[b]]) gave_way_[b] = 1;
  relax();
  return true;
}

// METHOD: v_n >= -(dist - 0.1 mm)/h.
void Stepper::relax() {
  for (ContactCandidate& c : candidates_) {
    if (!gave_way_[tree(c.shape)] && (c.other_shape < 0 || !gave_way_[tree(c.other_shape)])) continue;
    if (leaves_itself(c)) continue;
    c.target = std::min(c.target, c.dist >= 0 ? std::min(c.dist, kLeastGap) : c.dist);
    if (c.target >= 0 && c.target < kNarrow) tolerance_ = kFiner * world.settings.tolerance;
  }
  for (Contact& c : contacts_) c.target = candidates_[c.pair].target;
}

bool Stepper::within_limits(double h) const {
  for (const Contact& c : limits_)
    if (c.dist + h * limit_sign(c) * v_[limit_dof(c)] < c.target) return false;
  return true;
}

void Stepper::solve(double h) {
  const auto begin = std::chrono::steady_clock::now();
  slip_out();
  const size_t contacts = contacts_.size();
  for (size_t i = 0; i < limits_.size(); i++) limits_[i].pair = (int)(candidates_.size() + i);
  contacts_.insert(contacts_.end(), limits_.begin(), limits_.end());
  const SolveReport r = answer_touched(h);
  for (size_t i = 0; i < limits_.size(); i++) {
    // What solving leaves is cut: a joint goes no farther than it goes.
    Contact& c = limits_[i];
    c.impulse = contacts_[contacts + i].impulse;
    double& v = v_[limit_dof(c)];
    const double least = (c.target - c.dist) / h;
    if (limit_sign(c) * v < least) v = limit_sign(c) * least;
  }
  contacts_.resize(contacts);
  diagnostics_.sweeps += r.sweeps;
  diagnostics_.passes++;
  crushed_ = r.crushed;
  double n3 = 3.0 * r.points;
  work_ += n3 * n3 * (kRowWork + r.sweeps);
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
    for (int i = 0; i < 3 && !model.held[b]; i++)
      before[model.dof_first[b] + i] -= pulled_ * gravity[i];
  for (int i : articulations.dofs())
    if (pulled_ > 0) before[i] -= pull_[i];
  // Nor is the velocity in mid-step what it ends with where things spin fast.
  for (int i = 0; i < model.nv; i++) before[i] += spin_[i];
  std::vector<Twist> arrived, spun;
  body_twists(model, start_.kin, spin_.data(), spun);
  body_twists(model, start_.kin, before.data(), arrived);
  bool any = false;
  for (Contact& c : contacts_) {
    if (c.restitution <= 0 || dot(c.impulse, c.n) <= 0) continue;
    double arriving = approach(c, arrived, before);
    if (arriving > -kBounceSpeed) continue;
    double turned = approach(c, spun, spin_);
    double pull = std::max(0.0, arriving - turned - approach(c, twists_, v_free_));
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

// Solves for a step of length h from the start pose: velocities v_, their pose end_, whether all is
// well with it.
void Stepper::try_step(double h) {
  const double clear = world.settings.clearance;
  work_ = 0;
  crushed_ = false;
  gave_way_.assign(model.nbody, 0);
  body_twists(model, start_.kin, qvel_.data(), moving_);
  turning_.clear();
  body_twists(model, start_.kin, v_free_.data(), twists_);
  reach_.resize(world.shapes.size());
  fastest_.assign(model.nbody, 0);
  for (size_t i = 0; i < reach_.size(); i++) {
    reach_[i] = 0;
    const int b = world.shapes[i].body;
    if (!world.active[b]) continue;
    reach_[i] = h * speed_bound(world.shapes[i], twists_);
    if (reach_[i] > kFirstWay) {
      double way = kFirstFactor * h * speed_bound(world.shapes[i], moving_);
      reach_[i] = std::min(reach_[i], std::max(kFirstWay, way));
    }
    fastest_[model.root[b]] = std::max(fastest_[model.root[b]], reach_[i]);
  }
  // A contact can speed up what is slow now: a share of the fastest part's way for everyone.
  for (size_t i = 0; i < reach_.size(); i++) {
    const int b = world.shapes[i].body;
    if (world.active[b])
      reach_[i] = 1.25 * std::max(reach_[i], 0.35 * fastest_[model.root[b]]) + clear + kSlackReach;
  }
  articulations.limits(model, world.active, qpos_.data(), limits_);
  for (int query = 0; query < kQueries; query++) {
    for (CachedContact& w : warm_) w.used = false;
    contacts_.clear();
    forget_touched();
    solved_ = 0;
    tolerance_ = world.settings.tolerance;
    world.list(model, start_, reach_);
    world.gather(model, start_, reach_, h, candidates_);
    if (query == 0) squeeze();
    relax();
    diagnostics_.candidates = std::max(diagnostics_.candidates, (int)candidates_.size());
    v_ = v_free_;
    pose_at(v_, h, end_, q_end_);
    good_ = verify(h, 0, worst_) && within_limits(h);
    double most = work_ + kMostWork, least = kFar, mark = kFar;
    for (int pass = 1, stale = 0; !good_; pass++) {
      if (pass > kPasses || work_ > most || stale >= kStale) {
        if (least > kHopeless * clear || !give_way()) break;
        pass = 1, stale = 0;
        most = work_ + kMostWork, least = mark = kFar;
      }
      solve(h);
      pose_at(v_, h, end_, q_end_);
      good_ = verify(h, pass, worst_);
      if (crushed_) break;
      least = std::min(least, overdue_);
      stale = overdue_ == 0 || overdue_ < 0.5 * mark ? 0 : stale + 1;
      if (stale == 0) mark = overdue_;
    }
    if (!contacts_.empty()) good_ = bounce(h, good_, worst_);
    if (!good_) return;  // made shorter it stays within reach
    // Planes hold only for what was asked: ask again, from the start pose, for what moved more.
    bool beyond = false;
    ways(world.shapes, start_, end_, world.active, way_);
    for (size_t i = 0; i < reach_.size(); i++) {
      if (!world.active[world.shapes[i].body]) continue;
      double least = way_[i] + clear;
      if (least <= reach_[i]) continue;
      beyond = true;
      if (query + 1 < kQueries) reach_[i] = 1.25 * least + kSlackReach;
    }
    if (!beyond) return;
  }
  good_ = false;
}

void Stepper::substep(int k, double h) {
  inertia_ready_ = false;
  touched_.assign(model.nbody, 1);  // without contact nothing is held
  pushed_now_.assign(model.nbody, 0);
  if (world.any_inside()) world.reroute(model, start_);
  if (world.self_contact()) world.choose_again(model, start_);
  if (keep_times) solve_times.push_back(0);
  // Twists need the dofs' axes.
  start_.kin.update_dofs(model, qpos_.data(), world.active.data());
  set_pace();
  overcome_.assign(drives_.size(), 0);
  holds_.assign(drives_.size(), 1);
  share_.assign(model.nv, 1);
  free_velocity(k, h);
  v_star_ = v_free_;
  step_ = pulled_ = h;
  next_warm_.clear();
  trace.overcome.clear();
  attempt(h);
  while (slow_down(h) || give_in(h)) attempt(h);
  if (keep_trace) {
    trace.qpos = qpos_, trace.qvel = qvel_, trace.v_free = v_free_, trace.v = v_;
    if (contacts_.empty()) trace.contacts.clear();
    trace.touched = touched_;
    for (size_t p = 0; p < drives_.size(); p++)
      for (int i = 0; i < drives_[p].ball_count() && !holds_[p]; i++) trace.touched[drives_[p].body(i)] = 1;
    trace.h = h, trace.k = k;
  }
  const bool tracing = keep_trace;
  keep_trace = false;  // of the whole step only
  diagnostics_.contacts = std::max(diagnostics_.contacts, (int)contacts_.size());
  std::vector<double> share;
  double lost = 0;
  if (!good_) share = shares(h);
  if (share.empty())
    commit(h, share);
  else
    lost = retry(h, share);
  keep_trace = tracing;
  lost = std::max(lost, pass_time(h));
  if (lost > 0) diagnostics_.shortened++;
  diagnostics_.lost_time += lost;
  diagnostics_.residual = std::max(diagnostics_.residual, -worst_);
  warm_.swap(next_warm_);
  qvel_ = v_free_;
  for (int b : objects_)
    if (world.active[b])
      for (int i = 3; i < 6; i++) qvel_[model.dof_first[b] + i] += spin_[model.dof_first[b] + i];
  tally(h);
  for (Drive& d : drives_)
    if (world.active[d.body(0)]) d.end_substep(qvel_.data(), h, pushed_now_);
}

}  // namespace hp
