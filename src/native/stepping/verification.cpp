#include "stepping/verification.h"

#include <algorithm>

#include "collision/relative_travel.h"
#include "tuning.h"

namespace hp {

namespace tune = tuning::stepping;

namespace {

// By how much a candidate's gap may miss its target [m].
double allowed(const System& system, const Attempt& attempt, const ContactCandidate& c) {
  const World& world = system.world;
  const double miss = 2 * attempt.islands[c.island].tolerance + tune::kDistanceRounding;
  // Self-contact need not separate at an exact speed.
  if (system.self_overlap(c))
    return std::max(miss, (attempt.relaxed[system.tree(c.shape)] ? tune::kSelfExitSlackRelaxed
                                                                 : tune::kSelfExitSlack) *
                              (c.target - c.dist));
  double slack = miss;
  // Nor need objects that separate from a person whose pose is prescribed.
  if (world.forced && c.dist < 0 && world.handles(c))
    slack += tune::kGapSlack * (c.target - c.dist);
  if (c.target > 0) slack += tune::kGapSlack * c.target;
  // A kinematic body, which nothing stops, must not wear a gap away either.
  auto held = [&](int shape) { return shape >= 0 && system.model.held[world.shapes[shape].body]; };
  if (c.target >= 0 && (held(c.shape) || held(c.other_shape)))
    slack = std::min(slack, tune::kKinematicGapSlack * c.target + tune::kDistanceRounding);
  // Nor may many small steps wear away the last of it.
  if (c.dist > 0 && c.hard > 0.5 * c.dist)
    slack = std::min(slack, std::max(0.0, c.target - c.hard) + tune::kLeastMiss);
  // Nor may what has none left miss by more than the end check lets pass.
  if (c.target >= 0) slack = std::min(slack, c.target + tuning::collision::kBreach);
  return slack;
}

// People with recalled contacts are solved for anyhow: their candidates are checked after that, not
// before it too.
bool waits(const System& system, const ContactCandidate& c, const std::vector<char>& begun,
           const std::vector<char>& squeezed) {
  const World& world = system.world;
  if (c.soft >= 0 || !world.contact_points.recalls(c)) return false;
  if (c.other_static >= 0 && squeezed[world.shapes[c.shape].person]) return false;
  auto begins = [&](int shape) {
    return shape >= 0 && world.shapes[shape].person >= 0 && begun[world.shapes[shape].person];
  };
  return begins(c.shape) || begins(c.other_shape);
}

}  // namespace

// A bound of the same for what does not get as far as its plane, without posing it; none where it may.
static bool stays_off(const System& system, Data& data, ContactCandidate& c, double& least) {
  if (c.overlap >= 0 || c.dist <= c.target) return false;
  const std::vector<double>& way = data.step.way(system, data.state);
  const double room = c.dist - c.target - tune::kDistanceRounding;
  double went = way[c.shape] + (c.other_shape >= 0 ? way[c.other_shape] : 0);
  if (room > tuning::collision::kWaitingGap && room < went)
    went = pair_travel(system.world, c, data.state.pose, data.step.end, way);
  least = room - went;
  if (least < 0 || least + c.target < c.hard) return false;
  c.forgiven = false;
  return true;
}

static double find_excess(System& system, Data& data, size_t i, bool slack) {
  World& world = system.world;
  Poses &start = data.state.pose, &end = data.step.end;
  std::vector<ContactCandidate>& candidates = data.attempt.candidates;
  if (candidates[i].soft >= 0) return 0;
  double least = 0;
  bool off = stays_off(system, data, candidates[i], least);
  while (!off && candidates[i].known != Known::Plane) {
    world.narrow_phase.refine(system.model, start, data.step.length, (int)i, candidates);
    if (candidates[i].known == Known::Plane) data.budget.spend(tune::kPlaneWork);
    off = stays_off(system, data, candidates[i], least);
  }
  if (off) return least;
  const double e = world.gap_check.excess(
      system.model, start, end, candidates[i],
      slack ? std::max(0.0, allowed(system, data.attempt, candidates[i])) : 0.0);
  ContactCandidate& c = candidates[i];
  const bool hides = c.forgiven && c.triangle >= 0 && !c.searched &&
                     !world.gap_check.mesh_clear(system.model, c, start, end);
  const double work = tune::kCheckWork + tune::kTestWork * world.take_tests();
  data.budget.spend(work);
  data.attempt.islands[c.island].work += work;
  if (!hides) return e;
  // Where there are too many already it may not be crossed: the step is to be shorter.
  if (candidates.size() >= data.attempt.listed + tune::kMostHidden || data.budget.out())
    return world.gap_check.unforgiven(end, c);
  c.searched = true;
  std::vector<int>& hidden = data.attempt.hidden;
  const auto same_pair = [&](int k) { return pair_key(candidates[k]) == pair_key(c); };
  if (std::none_of(hidden.begin(), hidden.end(), same_pair)) hidden.push_back((int)i);
  return e;
}

double excess(System& system, Data& data, size_t i) { return find_excess(system, data, i, false); }

double excess_over_slack(System& system, Data& data, size_t i) {
  return find_excess(system, data, i, true);
}

bool search_hidden(System& system, Data& data, double h) {
  Attempt& attempt = data.attempt;
  const size_t before = attempt.candidates.size();
  for (int i : attempt.hidden)
    system.world.narrow_phase.search_behind(data.state.pose, attempt.valid, h, i,
                                            attempt.candidates);
  data.budget.spend(tune::kPlaneWork *
                        (attempt.hidden.size() + attempt.candidates.size() - before) +
                    tune::kTestWork * system.world.take_tests());
  attempt.hidden.clear();
  return attempt.candidates.size() > before;
}

void spend_on_poses(Data& data) {
  data.budget.spend(tune::kBoundWork * data.attempt.candidates.size() +
                    tune::kPoseWork * data.step.end.take_placed());
}

void Verification::check(System& system, Data& data, double h) {
  Attempt& attempt = data.attempt;
  for (IslandProgress& p : attempt.islands)
    if (p.open()) p.violated = false, p.worst = p.overdue = 0;
  for (size_t i = 0; i < attempt.candidates.size() || search_hidden(system, data, h); i++)
    check_candidate(system, data, i);
  spend_on_poses(data);
  find_overdue(system, data);
}

void Verification::check_first(System& system, Data& data, double h) {
  Attempt& attempt = data.attempt;
  const bool begun = recall(system, data);
  const auto put_off = [&](const ContactCandidate& c) {
    return waits(system, c, begun_, squeezed_);
  };
  const std::vector<ContactCandidate>& all = attempt.candidates;
  if (!begun || !std::all_of(all.begin(), all.end(), put_off))
    data.step.pose_end(system, data.step.v, h);
  if (!begun) return check(system, data, h);
  const size_t known = recalled_.size();
  for (size_t i = 0; i < attempt.candidates.size() || search_hidden(system, data, h); i++) {
    const ContactCandidate& c = attempt.candidates[i];
    if (i < known && put_off(c)) {
      attempt.violated.resize(i + 1, 0);
      attempt.excess.resize(i + 1, -1);  // not known: first of all
      attempt.violated[i] = recalled_[i];
      attempt.islands[c.island].violated |= recalled_[i] != 0;
    } else {
      check_candidate(system, data, i);
    }
  }
  spend_on_poses(data);
  find_overdue(system, data);
}

void Verification::check_candidate(System& system, Data& data, size_t i) {
  Attempt& attempt = data.attempt;
  attempt.violated.resize(attempt.candidates.size(), 0);
  attempt.excess.resize(attempt.candidates.size(), 0);
  const int island = attempt.candidates[i].island;
  if (!attempt.islands[island].open() || attempt.candidates[i].soft >= 0) return;
  const double e = excess_over_slack(system, data, i);
  attempt.excess[i] = e;
  const ContactCandidate& c = attempt.candidates[i];
  IslandProgress& p = attempt.islands[island];
  p.worst = std::min(p.worst, e);
  const bool violated = e < -allowed(system, attempt, c);
  attempt.violated[i] = violated;
  p.violated |= violated;
  if (violated && !system.is_object(c)) p.overdue = std::max(p.overdue, -e);
}

// Finds the candidates and people that contacts are recalled for; true if there are any.
bool Verification::recall(System& system, Data& data) {
  const World& world = system.world;
  const std::vector<ContactCandidate>& candidates = data.attempt.candidates;
  std::vector<CachedContact>& cached = data.cache.contacts();
  if (!world.contact_points.recall(data.state.pose, candidates, cached)) return false;
  recalled_.assign(candidates.size(), 0);
  begun_.assign(system.drives.size(), 0);
  // Between a kinematic body and a static, where there is hardly room, points of the substep before
  // lead far from where the deepest vertices do: a person there starts from those.
  squeezed_.assign(system.drives.size(), 0);
  for (const ContactCandidate& c : candidates)
    for (int shape : {c.shape, c.other_shape}) {
      if (c.other_shape < 0 || world.shapes[shape].person < 0) continue;
      const int other = shape == c.shape ? c.other_shape : c.shape;
      if (system.model.held[world.shapes[other].body]) squeezed_[world.shapes[shape].person] = 1;
    }
  bool any = false;
  for (CachedContact& w : cached) {
    if (w.candidate < 0) continue;
    const ContactCandidate& c = candidates[w.candidate];
    if (c.other_static >= 0 && squeezed_[world.shapes[c.shape].person]) {
      w.candidate = -1;
      continue;
    }
    any = true;
    recalled_[w.candidate] = 1;
    for (int shape : {c.shape, c.other_shape})
      if (shape >= 0 && world.shapes[shape].person >= 0) begun_[world.shapes[shape].person] = 1;
  }
  return any;
}

// Objects that lie on each other pass on what they carry, a pair more in every pass: of them only
// contacts that were solved for count.
void Verification::find_overdue(const System& system, Data& data) const {
  Attempt& attempt = data.attempt;
  for (const Contact& c : attempt.contacts) {
    const ContactCandidate& k = attempt.candidates[c.pair];
    IslandProgress& p = attempt.islands[k.island];
    if (!p.open() || !attempt.violated[c.pair] || !system.is_object(k)) continue;
    const double miss =
        c.target - system.world.contact_points.gap_at(data.state.pose, data.step.end, c);
    if (miss > tune::kObjectSettling * system.world.settings.clearance)
      p.overdue = std::max(p.overdue, miss);
  }
}

void thin_out(const System& system, Data& data, int island) {
  Attempt& attempt = data.attempt;
  size_t people = 0;
  for (const Drive& d : system.drives) people += data.islands.of_tree(d.body(0)) == island;
  people = std::max<size_t>(1, people);
  std::vector<char>& violated = attempt.violated;
  std::vector<int> order;
  for (size_t i = 0; i < violated.size(); i++)
    if (violated[i] && attempt.candidates[i].island == island) order.push_back((int)i);
  if (order.size() <= people * tune::kManyViolated) return;
  const std::vector<ContactCandidate>& all = attempt.candidates;
  std::stable_sort(order.begin(), order.end(), [&](int i, int j) {
    if (all[i].shape != all[j].shape) return all[i].shape < all[j].shape;
    return attempt.excess[i] < attempt.excess[j];
  });
  std::vector<int> chosen, left;  // of one shape, of all
  for (int i : order) {
    if (!chosen.empty() && all[chosen[0]].shape != all[i].shape) chosen.clear();
    bool same = (int)chosen.size() >= tune::kPatchPlanes;
    for (int k : chosen)
      same |=
          all[i].other_shape == all[k].other_shape && dot(all[i].n, all[k].n) > tune::kPatchNormal;
    violated[i] = !same;
    if (same) continue;
    chosen.push_back(i);
    left.push_back(i);
  }
  std::stable_sort(left.begin(), left.end(),
                   [&](int i, int j) { return attempt.excess[i] < attempt.excess[j]; });
  for (size_t k = people * tune::kMostPatchPlanes; k < left.size(); k++) violated[left[k]] = 0;
}

void check_limits(const System& system, Data& data, double h) {
  for (const Contact& c : data.attempt.limits)
    if (c.dist + h * limit_sign(c) * data.step.v[limit_dof(c)] < c.target)
      data.attempt.islands[data.islands.of_limit(system, c)].violated = true;
}

bool give_way(const System& system, Data& data, int island) {
  Attempt& attempt = data.attempt;
  if (attempt.relaxed[island]) return false;
  for (int b = 1; b < system.model.nbody; b++)
    if (data.islands.of_tree(b) == island) attempt.relaxed[b] = 1;
  relax(system, attempt);
  return true;
}

void relax(const System& system, Attempt& attempt) {
  const std::vector<char>& relaxed = attempt.relaxed;
  for (ContactCandidate& c : attempt.candidates) {
    if (!relaxed[system.tree(c.shape)] &&
        (c.other_shape < 0 || !relaxed[system.tree(c.other_shape)]))
      continue;
    if (system.self_overlap(c) || c.soft >= 0) continue;
    c.target =
        std::min(c.target, c.dist >= 0 ? std::min(c.dist, tuning::collision::kLeastGap) : c.dist);
    if (c.target >= 0 && c.target < tune::kNarrowGap)
      attempt.islands[c.island].tolerance =
          tune::kNarrowTolerance * system.world.settings.tolerance;
  }
  for (Contact& c : attempt.contacts) c.target = attempt.candidates[c.pair].target;
}

}  // namespace hp
