#include "stepping/contact_step.h"

#include <chrono>
#include <limits>

#include "tuning.h"

namespace hp {

namespace tune = tuning::stepping;

void ContactStep::run(double h) {
  Attempt& attempt = data_.attempt;
  begin(h);
  for (int query = 0; query < tune::kMostQueries; query++) {
    find_candidates(h, query == 0);
    data_.step.v = data_.step.v_free;
    attempt.good = check(h, 0) && within_limits(attempt, data_.step, h);
    if (!attempt.good) attempt.good = settle(h);
    if (!attempt.contacts.empty()) attempt.good = rebound(h, attempt.good);
    if (!attempt.good) return;  // made shorter it stays within reach
    if (!extend_reach(query + 1 == tune::kMostQueries || data_.budget.attempt_out())) return;
  }
}

void ContactStep::begin(double h) {
  Attempt& attempt = data_.attempt;
  attempt.crushed = false;
  data_.budget.begin_attempt();
  attempt.relaxed.assign(system_.model.nbody, 0);
  curvature_.begin(system_, data_.state);
  estimate_reach(h);
  system_.articulations.limits(system_.model, system_.world.active, data_.state.qpos.data(),
                               attempt.limits);
}

// How far v* takes each shape, and some more: a contact can speed up what is slow now.
void ContactStep::estimate_reach(double h) {
  const World& world = system_.world;
  const Kinematics& kin = data_.state.pose.kin;
  std::vector<double>& reach = data_.attempt.reach;
  body_twists(system_.model, kin, data_.step.v_free.data(), twists_);
  reach.resize(world.shapes.size());
  fastest_.assign(system_.model.nbody, 0);
  for (size_t i = 0; i < reach.size(); i++) {
    reach[i] = 0;
    const CollisionShape& shape = world.shapes[i];
    if (!world.active[shape.body]) continue;
    reach[i] = h * system_.speed_bound(kin, shape, twists_);
    if (reach[i] > tune::kFirstReach) {
      const double way =
          tune::kFirstReachFactor * h * system_.speed_bound(kin, shape, curvature_.velocity());
      reach[i] = std::min(reach[i], std::max(tune::kFirstReach, way));
    }
    double& fastest = fastest_[system_.model.root[shape.body]];
    fastest = std::max(fastest, reach[i]);
  }
  data_.attempt.moving = 0;
  for (size_t i = 0; i < reach.size(); i++) {
    const int b = world.shapes[i].body;
    data_.attempt.moving += world.active[b] != 0;
    if (world.active[b])
      reach[i] = tune::kReachFactor *
                     std::max(reach[i], tune::kSharedReach * fastest_[system_.model.root[b]]) +
                 world.settings.clearance + tune::kReachMargin;
  }
}

void ContactStep::find_candidates(double h, bool first) {
  World& world = system_.world;
  Attempt& attempt = data_.attempt;
  data_.cache.begin_attempt();
  attempt.contacts.clear();
  untouched_.begin(system_, data_.step.resistance, data_.inertia);
  attempt.solved = 0;
  attempt.tolerance = world.settings.tolerance;
  world.broad_phase.update(system_.model, data_.state.pose, attempt.reach,
                           world.depenetration.overlaps());
  attempt.valid = attempt.reach;
  world.narrow_phase.gather(system_.model, data_.state.pose, attempt.valid, h, attempt.candidates);
  if (data_.probe.blind > 0) attempt.candidates.clear();
  attempt.listed = attempt.candidates.size();
  attempt.hidden.clear();
  if (first) kinematic_.give_up_clearance(system_, data_);
  relax(system_, attempt);
  int& most = data_.result.diagnostics.candidates;
  most = std::max(most, (int)attempt.candidates.size());
  data_.budget.spend(tune::kPlaneWork * attempt.candidates.size());
}

// Moves, and checks every candidate at the end pose; adds contacts where one is violated.
bool ContactStep::check(double h, int pass) {
  data_.step.move(system_, data_.state, data_.step.v, h);
  if (verification_.check(system_, data_, h, pass)) return true;
  add_contacts(h, pass);
  return false;
}

// Solves and verifies until nothing is violated; true if that was reached.
bool ContactStep::settle(double h) {
  Attempt& attempt = data_.attempt;
  const double hopeless = tune::kHopelessMiss * system_.world.settings.clearance;
  const double infinite = std::numeric_limits<double>::infinity();
  double least = infinite, mark = infinite;
  bool good = false;
  for (int pass = 1, stale = 0; !good; pass++) {
    if (pass > 1 && data_.budget.attempt_out()) break;
    if (pass > tune::kMostPasses || stale >= tune::kStalePasses) {
      if (least > hopeless || !give_way(system_, data_)) break;
      pass = 1, stale = 0;
      least = mark = infinite;
    }
    solve(h);
    good = check(h, pass);
    if (attempt.crushed) break;
    least = std::min(least, attempt.overdue);
    stale = attempt.overdue == 0 || attempt.overdue < 0.5 * mark ? 0 : stale + 1;
    if (stale == 0) mark = attempt.overdue;
  }
  return good;
}

void ContactStep::add_contacts(double h, int pass) {
  Attempt& attempt = data_.attempt;
  Poses &start = data_.state.pose, &end = data_.step.end;
  if (pass > 0) body_twists(system_.model, start.kin, data_.step.v.data(), twists_);
  if (attempt.contacts.size() > tune::kMostContactPoints) drop_idle();
  const size_t old = attempt.contacts.size();
  thin_out(system_, attempt);
  for (size_t i = 0; i < attempt.candidates.size(); i++)
    if (attempt.violated[i])
      system_.world.contact_points.add(data_.cache.contacts(), start, end, attempt.candidates[i],
                                       (int)i, pass, attempt.contacts);
  for (size_t i = 0; i < attempt.contacts.size(); i++) {
    Contact& c = attempt.contacts[i];
    if (pass > 0) correct_prediction(c, h);
    if (i >= old && data_.cache.warm_start(system_, data_.state, attempt.candidates, c))
      curvature_.bend(system_, data_.state, attempt, c);
  }
}

// Contacts without an impulse that keep their gap make room for those that are needed.
void ContactStep::drop_idle() {
  std::vector<Contact>& contacts = data_.attempt.contacts;
  size_t kept = 0;
  for (Contact& c : contacts)
    if (norm2(c.impulse) > 0 ||
        system_.world.contact_points.gap_at(data_.state.pose, data_.step.end, c) < c.target)
      contacts[kept++] = c;
  contacts.resize(kept);
}

// The difference of the predicted gap and the one at the end pose, gap_end = dist + h v_n - shift.
// Bodies are not pushed apart faster than kMostCorrectionSpeed for its sake.
void ContactStep::correct_prediction(Contact& c, double h) {
  const Model& model = system_.model;
  const Poses& start = data_.state.pose;
  const World& world = system_.world;
  const bool object = !system_.is_person(world.shapes[data_.attempt.candidates[c.pair].shape].body);
  const double most = object ? tune::kMostObjectCorrectionSpeed : tune::kMostCorrectionSpeed;
  c.shift = std::min(c.dist + h * approach(model, start.kin, c, twists_, data_.step.v) -
                         world.contact_points.gap_at(data_.state.pose, data_.step.end, c),
                     std::max(0.0, c.dist - c.target) + h * most);
}

// A second solve where contacts rebound. True if nothing is violated after it, `good` where none
// rebounds.
bool ContactStep::rebound(double h, bool good) {
  if (data_.budget.attempt_out() || !rebounds_.demand(system_, data_, h)) return good;
  for (int pass = 1; pass <= tune::kMostReboundPasses; pass++) {
    solve(h);
    rebounds_.bound_energy(system_, data_, [&] { solve(h); });
    if (check(h, pass)) return true;
  }
  return false;
}

// Planes hold only for what was asked: true if a shape moved farther. Then it is asked again, from
// the start pose, with a larger reach. The attempt is not good if that was the last time, or if a
// mesh has too many planes to hold for more.
bool ContactStep::extend_reach(bool last) {
  const World& world = system_.world;
  Attempt& attempt = data_.attempt;
  bool beyond = false;
  travel_bounds(world.shapes, data_.state.pose, data_.step.end, world.active, way_);
  for (size_t i = 0; i < attempt.reach.size(); i++) {
    if (!world.active[world.shapes[i].body]) continue;
    const bool limited = attempt.valid[i] < attempt.reach[i];
    const double least = way_[i] + (limited ? tune::kBeyondReach : world.settings.clearance);
    if (least <= attempt.valid[i]) continue;
    beyond = true;
    last |= limited;
    if (!last) attempt.reach[i] = tune::kReachFactor * least + tune::kReachMargin;
  }
  attempt.good = !(beyond && last);
  return beyond && !last;
}

void ContactStep::solve(double h) {
  const auto begin = std::chrono::steady_clock::now();
  Attempt& attempt = data_.attempt;
  Probe& probe = data_.probe;
  kinematic_.drop_friction(system_, attempt);
  const size_t contacts = attempt.contacts.size();
  for (size_t i = 0; i < attempt.limits.size(); i++)
    attempt.limits[i].pair = (int)(attempt.candidates.size() + i);
  attempt.contacts.insert(attempt.contacts.end(), attempt.limits.begin(), attempt.limits.end());
  const SolveReport r = respond(h);
  cut_limits(contacts, h);
  attempt.contacts.resize(contacts);
  data_.result.diagnostics.sweeps += r.sweeps;
  data_.result.diagnostics.passes++;
  attempt.crushed = r.crushed;
  attempt.solved = contacts;
  if (probe.tracing) probe.trace.contacts = attempt.contacts;
  if (probe.keep_times)
    probe.solve_times.back() +=
        std::chrono::duration<double>(std::chrono::steady_clock::now() - begin).count();
}

// Joints do not leave their ranges: what solving leaves of that is cut. `first` is the first row of
// a joint.
void ContactStep::cut_limits(size_t first, double h) {
  Attempt& attempt = data_.attempt;
  for (size_t i = 0; i < attempt.limits.size(); i++) {
    Contact& c = attempt.limits[i];
    c.impulse = attempt.contacts[first + i].impulse;
    double& v = data_.step.v[limit_dof(c)];
    const double least = (c.target - c.dist) / h;
    if (limit_sign(c) * v < least) v = limit_sign(c) * least;
  }
}

// Solves, and again while that finds joints touched that were held. Islands without such a joint
// keep what was found.
SolveReport ContactStep::respond(double h) {
  const Model& model = system_.model;
  Attempt& attempt = data_.attempt;
  Step& step = data_.step;
  Islands& islands = data_.islands;
  untouched_.release(system_, attempt, step.resistance, data_.inertia);
  data_.inertia.build(system_, data_.state, step, step.length);
  SolveReport r = respond_once(h);
  while (untouched_.release(system_, attempt, step.resistance, data_.inertia)) {
    islands.find(system_, attempt.candidates);
    std::vector<char> again(model.nbody, 0);
    for (int b = 1; b < model.nbody; b++)
      if (untouched_.released()[b]) again[islands.of_tree(b)] = 1;
    const std::vector<Contact> before = attempt.contacts;
    const std::vector<double> v = step.v;
    data_.inertia.build(system_, data_.state, step, step.length);
    r.sweeps += respond_once(h).sweeps;
    for (size_t i = 0; i < before.size(); i++)
      if (before[i].pair < (int)attempt.candidates.size() &&
          !again[islands.of(system_, attempt.candidates[before[i].pair])])
        attempt.contacts[i].impulse = before[i].impulse;
    for (int i = 0; i < model.nv; i++)
      if (!again[islands.of_tree(model.root[model.dof_body[i]])]) step.v[i] = v[i];
  }
  return r;
}

// Self-contact first, then all contacts together (self_response.h).
SolveReport ContactStep::respond_once(double h) {
  Attempt& attempt = data_.attempt;
  Step& step = data_.step;
  const std::vector<double>* from = &step.v_free;
  if (system_.world.self_contact() && system_.drive_settings.time_constant > 0 &&
      self_.solve(system_, data_, solver_, h)) {
    size_t next = 0;
    for (Contact& c : attempt.contacts)
      if (self_.is_own(system_, attempt, c)) c.impulse = self_.own()[next++].impulse;
    if (next == attempt.contacts.size()) {
      step.v = self_.velocity();
      SolveReport r;
      r.points = (int)next;
      return r;
    }
    from = &self_.without_own(system_, data_);
  }
  const SolveReport r = solver_.solve(system_.model, data_.state.pose.kin, data_.inertia.matrix(),
                                      h, from->data(), step.v.data(), attempt.contacts,
                                      attempt.tolerance / h, system_.world.settings.max_sweeps,
                                      kinematic_.pushable_mass(system_), data_.budget.solve());
  data_.budget.spend(r.work);
  return r;
}

}  // namespace hp
