#include "stepping/sub_stepping.h"

#include <algorithm>

#include "collision/relative_travel.h"
#include "stepping/standing_friction.h"
#include "tuning.h"

namespace hp {

namespace tune = tuning::stepping;

double SubStepping::make(double h) {
  longest_.assign(system_.model.nbody, 0);
  std::vector<double> share;
  if (!good()) share = shares(h);
  data_.step.yielded_before = data_.step.yielded;
  if (!share.empty()) return go_on(h, share);
  commit(h, share);
  return 0;
}

// Is the step verified, and clear at its end?
bool SubStepping::good() {
  return data_.attempt.good && (data_.probe.blind > 1 || breached().empty());
}

// Pairs that overlap at the end pose, as they did not at its start, whatever the candidates say.
const std::vector<size_t>& SubStepping::breached() {
  measure_way();
  World& world = system_.world;
  const std::vector<size_t>& found =
      world.end_check.find(data_.state.pose, data_.step.end, way_, inner_);
  data_.budget.spend(tune::kTestWork * world.take_tests());
  return found;
}

// How far the step takes each shape.
void SubStepping::measure_way() {
  World& world = system_.world;
  Poses &start = data_.state.pose, &end = data_.step.end;
  if (way_stamp_ == end.stamp) return;
  way_stamp_ = end.stamp;
  way_ = data_.step.way(system_, data_.state);
  world.inner_travel(system_.model, start, end, inner_);
}

// The step is made up to these shares of it, by body; 1 for `ok`.
void SubStepping::move_to(const std::vector<double>& at, double h, std::vector<char>& ok) {
  const Model& model = system_.model;
  if (std::any_of(at.begin(), at.end(), [](double share) { return share != 1; })) {
    moved_.resize(model.nv);
    for (int i = 0; i < model.nv; i++) moved_[i] = data_.step.v[i] * at[model.dof_body[i]];
    data_.step.move(system_, data_.state, moved_, h);
  }
  for (ContactCandidate& c : data_.attempt.candidates)
    c.share = at[system_.world.shapes[c.shape].body];
  ok.assign(model.nbody, 1);
}

// Clears `ok` of islands whose shapes were taken beyond the reach that planes hold for.
void SubStepping::check_reach(std::vector<char>& ok) {
  const World& world = system_.world;
  const std::vector<double>& valid = data_.attempt.valid;
  measure_way();
  for (size_t i = 0; i < valid.size(); i++)
    if (world.active[world.shapes[i].body] && way_[i] + tune::kBeyondReach > valid[i])
      ok[data_.islands.of_tree(system_.tree((int)i))] = 0;
}

// Clears `ok` of the islands of a pair of the broad phase's list.
void SubStepping::refuse(size_t pair, std::vector<char>& ok) const {
  const BroadPhasePair& e = system_.world.broad_phase.pairs()[pair];
  for (int s : {e.shape, e.other_shape})
    if (s >= 0) ok[data_.islands.of_tree(system_.tree(s))] = 0;
}

void SubStepping::check_end(std::vector<char>& ok) {
  for (size_t pair : breached()) refuse(pair, ok);
}

// Clears `ok` of islands with joints too far beyond their ranges.
void SubStepping::check_ranges(std::vector<char>& ok) const {
  for (const RangeRow& row : data_.attempt.ranges)
    if (!JointRanges::holds(system_, data_, row))
      ok[data_.islands.of_limit(system_, row.contact)] = 0;
}

// Is the gap of candidate i large enough at the end pose? Clears `ok` of its island if not.
bool SubStepping::check_gap(size_t i, std::vector<char>& ok) {
  const double e = excess(system_, data_, i);
  const ContactCandidate& c = data_.attempt.candidates[i];
  if (c.soft >= 0 || e + c.target >= c.hard) return true;
  ok[data_.islands.of(system_, c)] = 0;
  return false;
}

// Per island: is everything clear with the shares `at`? What is not is looked at by possible(), too.
std::vector<char> SubStepping::clear(const std::vector<double>& at, double h) {
  Attempt& attempt = data_.attempt;
  std::vector<char> ok;
  move_to(at, h, ok);
  for (size_t i = 0; i < attempt.candidates.size() || search_hidden(system_, data_, h); i++)
    if (!check_gap(i, ok) && std::find(suspects_.begin(), suspects_.end(), i) == suspects_.end())
      suspects_.push_back(i);
  spend_on_poses(data_);
  check_end(ok);
  for (size_t pair : breached())
    if (std::find(end_suspects_.begin(), end_suspects_.end(), pair) == end_suspects_.end())
      end_suspects_.push_back(pair);
  check_ranges(ok);
  check_reach(ok);
  return ok;
}

// The same of what was not clear with larger shares.
std::vector<char> SubStepping::possible(const std::vector<double>& at, double h) {
  std::vector<char> ok;
  move_to(at, h, ok);
  for (size_t i : suspects_) check_gap(i, ok);
  spend_on_poses(data_);
  World& world = system_.world;
  for (size_t pair : end_suspects_)
    if (world.end_check.breached_at(data_.state.pose, data_.step.end, pair)) refuse(pair, ok);
  data_.budget.spend(tune::kTestWork * world.take_tests());
  check_ranges(ok);
  check_reach(ok);
  return ok;
}

// By island; leaves the end pose at those shares.
std::vector<double> SubStepping::shares(double h) {
  const Model& model = system_.model;
  std::vector<double> at(model.nbody, 1);
  data_.islands.find(system_, data_.attempt.candidates);
  suspects_.clear();
  end_suspects_.clear();
  for (int round = 0; round <= tune::kMostShareRounds; round++) {
    const std::vector<char> ok = clear(at, h);
    std::vector<char> hurt(model.nbody, 0);
    bool any = false;
    for (int b = 1; b < model.nbody; b++) {
      hurt[b] = system_.world.active[b] && at[b] > 0 && !ok[data_.islands.of_tree(model.root[b])];
      any |= hurt[b] != 0;
    }
    if (!any) return round > 0 ? at : std::vector<double>();
    if (round < tune::kMostShareRounds)
      bisect(at, hurt, h);
    else
      for (int b = 1; b < model.nbody; b++)
        if (hurt[b]) at[b] = 0;
  }
  stand_back(at, h);
  return at;
}

// The largest shares that possible() allows to islands that are hurt, smaller than theirs now.
void SubStepping::bisect(std::vector<double>& at, const std::vector<char>& hurt, double h) {
  const Model& model = system_.model;
  std::vector<double> good(model.nbody, 0), bad = at;
  for (int it = 0; it < tune::kShareBisections; it++) {
    for (int b = 1; b < model.nbody; b++)
      if (hurt[b]) at[b] = 0.5 * (good[b] + bad[b]);
    const std::vector<char> ok = possible(at, h);
    for (int b = 1; b < model.nbody; b++)
      if (hurt[b]) (ok[data_.islands.of_tree(model.root[b])] ? good[b] : bad[b]) = at[b];
  }
  for (int b = 1; b < model.nbody; b++)
    if (hurt[b]) at[b] = good[b];
}

// Islands whose shares were found apart may not do together: of those none makes any of its step.
void SubStepping::stand_back(std::vector<double>& at, double h) {
  const Model& model = system_.model;
  std::vector<char> ok;
  move_to(at, h, ok);
  check_end(ok);
  for (int b = 1; b < model.nbody; b++)
    if (!ok[data_.islands.of_tree(model.root[b])]) at[b] = 0;
}

// The step is made: by the trees' shares of it; trees with a negative one have not begun.
void SubStepping::commit(double h, const std::vector<double>& share) {
  World& world = system_.world;
  State& state = data_.state;
  Step& step = data_.step;
  const Model& model = system_.model;
  if (!share.empty()) {
    moved_.resize(model.nv);
    for (int i = 0; i < model.nv; i++)
      moved_[i] = step.v[i] * std::max(0.0, share[model.dof_body[i]]);
    step.move(system_, state, moved_, h);
  }
  Diagnostics& diagnostics = data_.result.diagnostics;
  double friction = 0;
  for (const IslandProgress& p : data_.attempt.islands) friction = std::max(friction, p.friction);
  diagnostics.friction = std::max(diagnostics.friction, friction);
  diagnostics.friction_tolerances =
      std::max(diagnostics.friction_tolerances, friction * h / world.settings.tolerance);
  record(h, share);
  breached();  // the end check looks at this end
  world.broad_phase.travel(way_, inner_);
  forget_shared_travel(world, world.broad_phase.pairs(), state.pose, step.end, way_);
  for (const Breach& k : world.end_check.commit(step.end)) data_.result.add(k);
  world.depenetration.advance(share);
  std::swap(state.pose, step.end);
  state.qpos = step.end_qpos;
  std::vector<double>* pieces = data_.probe.pieces;
  if (pieces) pieces->insert(pieces->end(), state.qpos.begin(), state.qpos.end());
  for (int i = 0; i < model.nv; i++)
    if (share.empty() || share[model.dof_body[i]] >= 0) step.v_free[i] = step.v[i];
  const std::vector<double>& kick = data_.soft.kick();
  for (size_t i = 0; i < kick.size(); i++) step.v_free[i] += kick[i];
}

// Trees whose longest piece of this substep is now being made, so far.
std::vector<char> SubStepping::longest(double h, const std::vector<double>& share) {
  const Model& model = system_.model;
  std::vector<char> out(model.nbody, 0);
  for (int b = 1; b < model.nbody; b++) {
    if (model.root[b] != b || !system_.world.active[b]) continue;
    const double length = h * (share.empty() ? 1.0 : share[b]);
    out[b] = length >= longest_[b];
    longest_[b] = std::max(longest_[b], length);
  }
  return out;
}

// The contacts of trees that have made a step, whole or shortened. The next substep starts from those
// of the longest piece: a short one at the end touches little.
void SubStepping::record(double h, const std::vector<double>& share) {
  Attempt& attempt = data_.attempt;
  const std::vector<char> renewed = longest(h, share);
  data_.cache.drop(system_, renewed);
  // Contacts found after the last solve only carry a guess.
  attempt.contacts.resize(std::min(attempt.contacts.size(), attempt.solved));
  for (const Contact& c : attempt.contacts) {
    const ContactCandidate& k = attempt.candidates[c.pair];
    if (!share.empty() && share[data_.islands.of(system_, k)] < 0) continue;
    const bool kept = renewed[system_.tree(k.shape)];
    if (norm2(c.impulse) == 0) {
      if (kept && k.other_static >= 0 && system_.world.contact_points.recalls(k))
        data_.cache.keep(system_, data_.state, k, c);
      continue;
    }
    data_.result.disturbed[system_.tree(k.shape)] = 1;
    if (k.other_shape >= 0) data_.result.disturbed[system_.tree(k.other_shape)] = 1;
    for_each_pushed(system_, k, [&](int b) { data_.step.pushed[b] = 1; });
    if (kept) data_.cache.keep(system_, data_.state, k, c);
    data_.result.add(k, c);
  }
  data_.soft.record(system_, data_, h, share);
  StandingFriction::record(system_, data_, share);
}

// Islands found their shares each by itself: are all active trees clear at the least of these, too? What is
// clear at the end of its step need not be half-way.
bool SubStepping::clear_together(const std::vector<double>& share, double least, double h) {
  const Model& model = system_.model;
  const auto active = [&](int b) { return system_.world.active[b] != 0; };
  bool differ = false;
  for (int b = 1; b < model.nbody; b++) differ |= active(b) && share[b] != least;
  if (!differ) return true;
  const std::vector<char> ok = clear(std::vector<double>(model.nbody, least), h);
  for (int b = 1; b < model.nbody; b++)
    if (active(b) && !ok[data_.islands.of_tree(model.root[b])]) return false;
  return true;
}

// Active trees try to make the rest of their step, `left`, in pieces short enough. Returns the time
// that is lost.
double SubStepping::catch_up(double h, double left, bool begun) {
  const Model& model = system_.model;
  const std::vector<char>& active = system_.world.active;
  State& state = data_.state;
  double length = begun ? left : tune::kShorterPiece * left;
  for (int piece = 1; left > tune::kNoTimeLeft * h; piece++) {
    if (piece > tune::kMostPieces || data_.budget.out()) return left;
    if (begun) {
      // The velocities are kept: what contacts gave is in them.
      data_.cache.clear();
      data_.step.gravity_time = 0;
    }
    if (begun || piece == 1) {
      data_.step.end = state.pose;
      state.pose.kin.update_dofs(model, state.qpos.data(), active.data());
      data_.inertia.forget();
    }
    length = std::min(length, left);
    do attempts_.run(length);
    while (strength_.give_in(system_, data_, data_.step.length));
    data_.step.yielded_before = data_.step.yielded;
    std::vector<double> share;
    if (!good()) share = shares(length);
    double least = 1;
    for (int b = 1; b < model.nbody && !share.empty(); b++)
      if (active[b]) least = std::min(least, share[b]);
    if (least < 1 && !clear_together(share, least, length)) least = 0;
    if (least < tune::kLeastShare && piece < tune::kMostPieces) {
      length *= tune::kShorterPiece;
      continue;
    }
    strength_.keep(system_, data_, std::vector<double>(model.nbody, least));
    if (least < 1) share.assign(model.nbody, least);
    commit(length, share);
    begun = true;
    left -= least * length;
    if (least == 1) length *= 2;
  }
  return 0;
}

// One island is active; all other trees stand where they are.
void SubStepping::activate(int island, const std::vector<int>& islands,
                           const std::vector<char>& all, const std::vector<char>& stood) {
  World& world = system_.world;
  for (int b = 1; b < system_.model.nbody; b++) {
    world.active[b] = all[b] && islands[system_.model.root[b]] == island;
    world.standing[b] = stood[b] || (all[b] && !world.active[b]);
  }
}

// Things for which no time has passed have not fallen either: they keep the velocity that they came with.
// (Those of another engine have the one that it gave them.)
void SubStepping::keep_velocity() {
  const Model& model = system_.model;
  Step& step = data_.step;
  if (step.host_v_free) return;
  for (int i = 0; i < model.nv; i++) {
    const int b = model.dof_body[i];
    if (!system_.world.active[b] || system_.is_person(b)) continue;
    step.v_free[i] = data_.state.qvel[i];
    step.spin[i] = 0;
  }
}

// Commits the shares; islands that made only a share of the step go on one after the other. Returns
// the most time that one lost.
double SubStepping::go_on(double h, std::vector<double> share) {
  const Model& model = system_.model;
  World& world = system_.world;
  const std::vector<char> all = world.active, stood = world.standing;
  const std::vector<int> islands = data_.islands.all();
  const double gravity_time = data_.step.gravity_time;
  std::vector<double> left(model.nbody, 0);
  for (int b = 1; b < model.nbody; b++) {
    if (!all[b] || share[b] == 1) continue;
    if (share[b] < tune::kLeastShare) share[b] = -1;
    left[b] = h * (1 - std::max(0.0, share[b]));
    data_.result.disturbed[model.root[b]] = 1;
  }
  strength_.keep(system_, data_, share);
  commit(h, share);
  double lost = 0;
  const std::vector<CachedContact> warm = data_.cache.contacts();
  for (int first = 1; first < model.nbody; first++) {
    if (left[first] == 0 || model.root[first] != first) continue;
    const double rest = left[first];
    activate(islands[first], islands, all, stood);
    for (int b = 1; b < model.nbody; b++)
      if (world.active[b]) left[b] = 0;
    data_.step.gravity_time = gravity_time;
    data_.cache.restore(warm);
    const double late = catch_up(h, rest, share[first] >= 0);
    if (share[first] < 0 && late == rest) keep_velocity();
    for (int b = 1; b < model.nbody; b++)
      if (world.active[b]) kinematic_.set_late(b, late);
    lost = std::max(lost, late);
  }
  world.active = all;
  world.standing = stood;
  return lost;
}

}  // namespace hp
