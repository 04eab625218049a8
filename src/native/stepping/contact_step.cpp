#include "stepping/contact_step.h"

#include <algorithm>
#include <chrono>
#include <limits>

#include "tuning.h"

namespace hp {

namespace tune = tuning::stepping;

void ContactStep::run(double h) {
  begin(h);
  for (int query = 0; query < tune::kMostQueries; query++) {
    find_candidates(h);
    data_.step.v = data_.step.v_free;
    data_.step.braced.clear();
    settle(h);
    if (!data_.attempt.contacts.empty()) rebound(h);
    ranges_.end(system_, data_);
    find_worst(data_.attempt);
    if (!extend_reach(query + 1 == tune::kMostQueries)) return;
  }
}

void ContactStep::begin(double h) {
  Attempt& attempt = data_.attempt;
  data_.budget.begin_attempt();
  curvature_.begin(system_, data_.state);
  estimate_reach(h);
  system_.articulations.limits(system_.model, system_.world.active, data_.state.qpos.data(),
                               attempt.limits);
  standing_.find(system_, data_, h);
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
  for (size_t i = 0; i < reach.size(); i++) {
    const int b = world.shapes[i].body;
    if (world.active[b])
      reach[i] = tune::kReachFactor *
                     std::max(reach[i], tune::kSharedReach * fastest_[system_.model.root[b]]) +
                 world.settings.clearance + tune::kReachMargin;
  }
}

void ContactStep::find_candidates(double h) {
  World& world = system_.world;
  Attempt& attempt = data_.attempt;
  data_.cache.begin_attempt();
  attempt.contacts.clear();
  attempt.violated.clear();
  attempt.relaxed.assign(system_.model.nbody, 0);
  ranges_.begin(system_, data_, h);
  response_.begin(system_, data_);
  attempt.solved = 0;
  world.broad_phase.update(system_.model, data_.state.pose, attempt.reach,
                           world.depenetration.overlaps());
  attempt.valid = attempt.reach;
  world.narrow_phase.gather(system_.model, data_.state.pose, attempt.valid, h, attempt.candidates);
  if (data_.probe.blind > 0) attempt.candidates.clear();
  data_.soft.gather(system_, data_);
  attempt.listed = attempt.candidates.size();
  attempt.hidden.clear();
  find_islands();
  kinematic_.give_up_clearance(system_, data_);
  relax(system_, attempt);
  int& most = data_.result.diagnostics.candidates;
  most = std::max(most, (int)attempt.candidates.size());
  data_.budget.spend(tune::kPlaneWork * attempt.planes() + tune::kTestWork * world.take_tests());
}

void ContactStep::find_islands() {
  Attempt& attempt = data_.attempt;
  data_.islands.find(system_, attempt.candidates);
  IslandProgress fresh;
  fresh.tolerance = system_.world.settings.tolerance;
  fresh.begin();
  attempt.islands.assign(system_.model.nbody, fresh);
  for (ContactCandidate& c : attempt.candidates) {
    c.island = data_.islands.of(system_, c);
    double& tolerance = attempt.islands[c.island].tolerance;
    if (c.soft < 0 && c.target >= 0 && c.target < tune::kNoGap)
      tolerance = std::min(tolerance, tune::kNoGapTolerance);
  }
}

// Solves and verifies until nothing is violated, each island until it has settled or is stuck.
void ContactStep::settle(double h) {
  data_.step.find_end(system_, data_.state, data_.step.v, h);
  verification_.check_first(system_, data_, h);
  check_limits(system_, data_, h);
  ranges_.check(system_, data_, h);
  standing_.look(system_, data_);
  data_.soft.choose_rules(system_, data_, h);
  data_.soft.look(system_, data_, h, true);
  bool open = false;
  for (IslandProgress& p : data_.attempt.islands) {
    p.state = p.violated ? IslandProgress::State::Open : IslandProgress::State::Settled;
    open |= p.violated;
  }
  if (open) add_contacts(h);
  while (open) {
    solve(h);
    data_.step.move(system_, data_.state, data_.step.v, h);
    verification_.check(system_, data_, h);
    ranges_.check(system_, data_, h);
    for (IslandProgress& p : data_.attempt.islands) p.pass++;
    data_.soft.look(system_, data_, h, false);
    open = false;
    for (IslandProgress& p : data_.attempt.islands) {
      if (p.open() && !p.violated) p.state = IslandProgress::State::Settled;
      open |= p.open();
    }
    if (!open) break;
    add_contacts(h);
    open = false;
    for (int b = 1; b < system_.model.nbody; b++)
      if (data_.attempt.islands[b].open()) open |= goes_on(b);
    drop_unsolved();
  }
}

// After a solve that left something violated: is the island to be solved again?
bool ContactStep::goes_on(int island) {
  IslandProgress& p = data_.attempt.islands[island];
  const double hopeless = tune::kHopelessMiss * system_.world.settings.clearance;
  p.least = std::min(p.least, p.overdue);
  p.stale = p.overdue == 0 || p.overdue < 0.5 * p.mark ? 0 : p.stale + 1;
  if (p.stale == 0) p.mark = p.overdue;
  const bool spent = p.pass >= tune::kMostPasses || p.stale >= tune::kStalePasses;
  const bool out = data_.budget.attempt_out(p.work);
  if (!p.crushed && !out && !spent) return true;
  const bool curable = spent && !p.crushed && p.least <= hopeless;
  if (out ||
      !(ranges_.hold_fast(system_, data_, island) ||
        (curable && give_way(system_, data_, island)) || ranges_.give_way(system_, data_, island)))
    p.state = IslandProgress::State::Stuck;
  else
    p.begin();
  return p.open();
}

bool ContactStep::settled() const {
  for (const IslandProgress& p : data_.attempt.islands)
    if (p.state != IslandProgress::State::Settled) return false;
  return true;
}

// Points of the violated candidates of open islands; those that there are get better predictions.
void ContactStep::add_contacts(double h) {
  Attempt& attempt = data_.attempt;
  Poses &start = data_.state.pose, &end = data_.step.end;
  body_twists(system_.model, start.kin, data_.step.v.data(), twists_);
  if (attempt.contacts.size() > tune::kMostContactPoints) drop_idle();
  const size_t old = attempt.contacts.size();
  double work = 0;
  for (int b = 1; b < system_.model.nbody; b++)
    if (attempt.islands[b].open()) thin_out(system_, data_, b);
  for (size_t i = 0; i < attempt.candidates.size(); i++) {
    const IslandProgress& p = attempt.islands[attempt.candidates[i].island];
    if (!p.open() || !attempt.violated[i]) continue;
    work += tune::kPointWork + tune::kLookWork * attempt.contacts.size();
    system_.world.contact_points.add(data_.cache.contacts(), start, end, attempt.candidates[i],
                                     (int)i, p.pass, attempt.contacts);
  }
  work += tune::kPointWork * attempt.contacts.size() +
          tune::kLookWork * (attempt.contacts.size() - old) * data_.cache.contacts().size();
  data_.budget.spend(tune::kTestWork * system_.world.take_tests() + work);
  data_.soft.linearise(system_, data_, h, twists_);
  for (size_t i = 0; i < attempt.contacts.size(); i++) {
    Contact& c = attempt.contacts[i];
    const IslandProgress& p = attempt.islands[attempt.candidates[c.pair].island];
    if (!p.open()) continue;
    if (attempt.solved > 0 || p.pass > 0) correct_prediction(c, h);
    if (i >= old && data_.cache.warm_start(system_, data_.state, attempt.candidates, c))
      curvature_.bend(system_, data_.state, attempt, c);
  }
  place_friction(h);
}

void ContactStep::place_friction(double h) {
  const Kinematics& kin = data_.state.pose.kin;
  places_.place(
      system_.world, data_.state.pose, data_.cache.contacts(), data_.attempt.candidates,
      data_.attempt.solved, data_.attempt.contacts,
      [&](const Contact& c) {
        return c.target - c.dist + c.shift -
               h * approach(system_.model, kin, c, twists_, data_.step.v);
      },
      [&](const Contact& c) {
        return h * norm(endpoint_turn(twists_, c.a) - endpoint_turn(twists_, c.b)) >
               tune::kTurnsFar;
      });
}

// Contacts found after the last solve of an island that is not solved again only carry a guess.
void ContactStep::drop_unsolved() {
  Attempt& attempt = data_.attempt;
  const auto closed = [&](const Contact& c) {
    return !attempt.islands[attempt.candidates[c.pair].island].open();
  };
  std::vector<Contact>& contacts = attempt.contacts;
  const auto first = contacts.begin() + (long)std::min(attempt.solved, contacts.size());
  contacts.erase(std::remove_if(first, contacts.end(), closed), contacts.end());
}

// Contacts of islands with too many of them that carry no impulse and keep their gap make room for
// those that are needed.
void ContactStep::drop_idle() {
  std::vector<Contact>& contacts = data_.attempt.contacts;
  const auto island = [&](const Contact& c) { return data_.attempt.candidates[c.pair].island; };
  std::vector<size_t> count(system_.model.nbody, 0);
  for (const Contact& c : contacts) count[island(c)]++;
  size_t kept = 0;
  for (Contact& c : contacts)
    if (count[island(c)] <= tune::kMostContactPoints || !data_.attempt.islands[island(c)].open() ||
        norm2(c.impulse) > 0 ||
        system_.world.contact_points.gap_at(data_.state.pose, data_.step.end, c) < c.target)
      contacts[kept++] = c;
  contacts.resize(kept);
}

// The largest violation that is left.
void ContactStep::find_worst(Attempt& attempt) {
  attempt.worst = 0;
  for (const IslandProgress& p : attempt.islands) attempt.worst = std::min(attempt.worst, p.worst);
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

// A second solve of islands where contacts rebound: they are as far as it has come.
void ContactStep::rebound(double h) {
  if (!rebounds_.demand(system_, data_)) return;
  for (int pass = 1; pass <= tune::kMostReboundPasses; pass++) {
    solve(h);
    rebounds_.bound_energy(system_, data_, [&] { solve(h); });
    data_.step.move(system_, data_.state, data_.step.v, h);
    verification_.check(system_, data_, h);
    bool open = false;
    for (IslandProgress& p : data_.attempt.islands) {
      if (!p.open()) continue;
      p.pass = pass;
      if (!p.violated) p.state = IslandProgress::State::Settled;
      open |= p.violated;
    }
    if (!open) break;
    add_contacts(h);
  }
  for (IslandProgress& p : data_.attempt.islands)
    if (p.open()) p.state = IslandProgress::State::Stuck;
}

// Planes hold only for what was asked: true if a shape of an island that has settled moved farther.
// Then it is asked again, from the start pose, with a larger reach. The island is stuck if that was
// the last time, or if a mesh has too many planes to hold for more. One that is stuck is not asked
// again: made shorter it stays within reach.
bool ContactStep::extend_reach(bool last) {
  const World& world = system_.world;
  Attempt& attempt = data_.attempt;
  way_ = data_.step.way(system_, data_.state);
  beyond_.clear();
  for (int i = 0; i < (int)attempt.reach.size(); i++) {
    if (!world.active[world.shapes[i].body]) continue;
    const bool limited = attempt.valid[i] < attempt.reach[i];
    way_[i] += limited ? tune::kBeyondReach : world.settings.clearance;
    if (way_[i] <= attempt.valid[i]) continue;
    IslandProgress& p = attempt.islands[data_.islands.of_tree(system_.tree(i))];
    if (last || limited) p.state = IslandProgress::State::Stuck;
    beyond_.push_back(i);
  }
  bool again = false;
  for (const int i : beyond_) {
    const int island = data_.islands.of_tree(system_.tree(i));
    if (attempt.islands[island].state != IslandProgress::State::Settled) continue;
    attempt.reach[i] = tune::kReachFactor * way_[i] + tune::kReachMargin;
    again = true;
  }
  attempt.good = settled();
  return again;
}

void ContactStep::solve(double h) {
  const auto begin = std::chrono::steady_clock::now();
  Attempt& attempt = data_.attempt;
  Probe& probe = data_.probe;
  kinematic_.drop_friction(system_, data_);
  const size_t contacts = attempt.contacts.size();
  for (size_t i = 0; i < attempt.limits.size(); i++)
    attempt.limits[i].pair = (int)(attempt.candidates.size() + i);
  attempt.contacts.insert(attempt.contacts.end(), attempt.limits.begin(), attempt.limits.end());
  for (RangeRow& row : attempt.ranges) {
    row.contact.pair = (int)(attempt.candidates.size() + attempt.contacts.size());
    attempt.contacts.push_back(row.contact);
  }
  std::vector<Contact>& soft = data_.soft.rows();
  const size_t first_soft = attempt.contacts.size();
  attempt.contacts.insert(attempt.contacts.end(), soft.begin(), soft.end());
  const size_t first_standing = attempt.contacts.size();
  for (StandingRow& row : attempt.standing) {
    row.contact.pair = (int)(attempt.candidates.size() + attempt.contacts.size());
    attempt.contacts.push_back(row.contact);
  }
  response_.solve(system_, data_, kinematic_, h);
  for (size_t i = 0; i < attempt.standing.size(); i++)
    attempt.standing[i].contact.impulse = attempt.contacts[first_standing + i].impulse;
  for (size_t i = 0; i < soft.size(); i++)
    soft[i].impulse = attempt.contacts[first_soft + i].impulse;
  cut_limits(contacts, h);
  for (size_t i = 0; i < attempt.ranges.size(); i++)
    attempt.ranges[i].contact.impulse =
        attempt.contacts[contacts + attempt.limits.size() + i].impulse;
  attempt.contacts.resize(contacts);
  data_.result.diagnostics.passes++;
  attempt.solved = contacts;
  if (probe.tracing) probe.trace.contacts = attempt.contacts, probe.trace.ranges = attempt.ranges;
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

}  // namespace hp
