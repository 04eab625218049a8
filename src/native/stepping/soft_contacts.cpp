#include "stepping/soft_contacts.h"

#include <algorithm>
#include <map>

#include "stepping/data.h"
#include "stepping/untouched_joints.h"
#include "tuning.h"

namespace hp {

namespace soft_tune = tuning::soft;

void SoftContacts::finish(const System& system) {
  pairs_.finish(system);
  reset(system.model);
}

void SoftContacts::reset(const Model& m) {
  pairs_.forget();
  friction_.assign(pairs_.size(), {});
  rules_.reset(m, any());
  cells_.clear();
  active_.clear();
  groups_.clear();
  rows_.clear();
}

void SoftContacts::mark_busy(const System& system, Data& data, const std::vector<double>& travel,
                             std::vector<char>& busy) {
  for (int k = 0; k < pairs_.size(); k++) {
    SoftPair& pair = pairs_[k];
    const int a = system.tree(pair.shape);
    const int b = pair.other_shape >= 0 ? system.tree(pair.other_shape) : a;
    if (busy[a] && busy[b]) continue;
    const double way = travel[pair.shape] + (pair.other_shape >= 0 ? travel[pair.other_shape] : 0);
    if (pairs_.near(system, data, pair, way)) busy[a] = busy[b] = 1;
  }
}

void SoftContacts::gather(const System& system, Data& data) {
  active_.clear();
  groups_.clear();
  rows_.clear();
  if (!any()) return;
  Attempt& attempt = data.attempt;
  Poses& start = data.state.pose;
  for (int k = 0; k < pairs_.size(); k++) {
    SoftPair& pair = pairs_[k];
    if (!SoftPairs::takes_part(system, pair)) continue;
    const double reach =
        attempt.reach[pair.shape] + (pair.other_shape >= 0 ? attempt.reach[pair.other_shape] : 0);
    if (!pairs_.near(system, data, pair, reach)) continue;
    if (pair.stamp != start.stamp || pair.reach < reach) {
      find_near(system.world, system.soft, cells_, start, reach, SoftPairs::travelled(system, pair),
                pair);
      data.budget.spend(soft_tune::kSampleWork * system.soft.samples_of(pair.shape).size());
    }
    if (pair.near.empty()) continue;
    ContactCandidate c;
    c.shape = pair.shape, c.other_static = pair.other_static, c.other_shape = pair.other_shape;
    c.soft = k;
    active_.push_back({k, (int)attempt.candidates.size()});
    attempt.candidates.push_back(c);
  }
  group_active();
}

void SoftContacts::group_active() {
  const auto group = [&](const Entry& e) { return pairs_[e.pair].group; };
  std::stable_sort(active_.begin(), active_.end(),
                   [&](const Entry& a, const Entry& b) { return group(a) < group(b); });
  for (int i = 0; i < (int)active_.size(); i++) {
    if (i == 0 || group(active_[i]) != group(active_[i - 1])) groups_.push_back({i, i, false, {}});
    groups_.back().end = i + 1;
  }
  if (rows_of_.size() < groups_.size()) rows_of_.resize(groups_.size());
  for (const Group& g : groups_) list_members(g);
}

int SoftContacts::island(const Data& data, const Group& group) const {
  return data.attempt.candidates[active_[group.first].candidate].island;
}

void SoftContacts::choose_rules(const System& system, Data& data, double h) {
  if (active_.empty()) return;
  rules_.choose(system, data);
  for (const Entry& e : active_) {
    const int island = data.attempt.candidates[e.candidate].island;
    if (rules_.of(island) == Rule::Mean && stiff(system, data, pairs_[e.pair], h))
      rules_.set(island, Rule::End);
  }
}

// Is an object's bounce on the layer too fast for a step of h, where v* takes it?
bool SoftContacts::stiff(const System& system, Data& data, SoftPair& pair, double h) const {
  if (!find_depths(system.world, system.soft, data.step.end, SoftPairs::way(system, data, pair),
                   pair))
    return false;
  find_pressures(Rule::End, h, pair);
  double firmness = 0;  // h^2 times the stiffness
  const double *area = pair.near[NearSamples::Area], *slope = pair.near[NearSamples::Slope];
  for (int i = 0; i < pair.near.size(); i++) firmness += h * h * area[i] * slope[i];
  double mass = system.model.mass[system.world.shapes[pair.shape].body];
  if (pair.other_shape >= 0)
    mass = std::min(mass, system.model.mass[system.world.shapes[pair.other_shape].body]);
  return firmness > soft_tune::kStiffBounce * mass;
}

void SoftContacts::list_members(const Group& group) {
  GroupRows& its = rows_of(group);
  its.clear();
  for (int i = group.first; i < group.end; i++) {
    its.members.push_back(&pairs_[active_[i].pair]);
    its.candidates.push_back(active_[i].candidate);
  }
}

// By the pressures that were looked at last.
void SoftContacts::list_pressed(Rule rule, double h, Vec3 way, const Group& group) {
  GroupRows& its = rows_of(group);
  its.pressed.clear();
  for (int k = 0; k < (int)its.members.size(); k++)
    hp::list_pressed(*its.members[k], k, rule, h, way, its.pressed);
}

// Where impulses of a group are taken about.
Vec3 SoftContacts::middle(const System& system, Poses& pose, const Group& group) const {
  return pose.cached_bounding_sphere(system.world.shapes, pairs_[active_[group.first].pair].shape)
      .center;
}

// How far its middle has gone to the pose looked at; a guess looks at none.
Vec3 SoftContacts::went(const System& system, Data& data, const Group& group) const {
  if (group.guessed) return {};
  return middle(system, data.step.end, group) - middle(system, data.state.pose, group);
}

bool SoftContacts::has(const Group& group, int candidate) const {
  for (int i = group.first; i < group.end; i++)
    if (active_[i].candidate == candidate) return true;
  return false;
}

// What the rows of a group have exerted along their normals.
PairImpulse SoftContacts::applied(const Group& group, Vec3 about) const {
  PairImpulse sum;
  for (const Contact& c : rows_) {
    if (!has(group, c.pair)) continue;
    const double q = dot(c.impulse, c.n);
    sum.force += q * c.n;
    sum.moment += q * cross(c.position - about, c.n);
    sum.size += q;
  }
  return sum;
}

// The twist of a body about the origin, in the step before.
Twist SoftContacts::about_origin(const System& system, const Data& data, int body) const {
  const Twist& t = twists_[body];
  return {t.w, t.v - cross(t.w, data.state.pose.kin.reference(system.model, body))};
}

// Pressures where the samples of a person go on with the velocity of the step before. False if it presses
// nothing there.
bool SoftContacts::guess(const System& system, Data& data, double h, Group& group) {
  const SoftPair& first = pairs_[active_[group.first].pair];
  const CollisionShape& shape = system.world.shapes[first.shape];
  if (shape.person < 0 || rules_.of(island(data, group)) != Rule::End) return false;
  const auto twist = [&](const SoftPair& pair) {
    const Twist t = about_origin(system, data, system.world.shapes[pair.shape].body);
    if (pair.other_shape < 0) return t;
    const Twist o = about_origin(system, data, system.world.shapes[pair.other_shape].body);
    return Twist{t.w - o.w, t.v - o.v};
  };
  group.twist = twist(first);
  for (int i = group.first; i < group.end; i++) {
    SoftPair& pair = pairs_[active_[i].pair];
    const Twist its = twist(pair);
    guess_depths(h, its.v, its.w, pair);
    find_pressures(Rule::End, h, pair);
    group.guessed |= presses(pair);
  }
  return group.guessed;
}

// Pressures at the end pose. True if they are those of the rows.
bool SoftContacts::measure(const System& system, Data& data, double h, const Group& group) {
  const Rule rule = rules_.of(island(data, group));
  const Vec3 from = middle(system, data.state.pose, group);
  const Vec3 to = middle(system, data.step.end, group);
  for (int i = group.first; i < group.end; i++) {
    SoftPair& pair = pairs_[active_[i].pair];
    find_depths(system.world, system.soft, data.step.end, SoftPairs::way(system, data, pair), pair);
    data.budget.spend(soft_tune::kSampleWork * (double)pair.near.size());
    find_pressures(rule, h, pair);
  }
  const PairImpulse now = total_impulse(rows_of(group).members, rule, h, to - from, to);
  // The rows lie where the layer was when they were made.
  const PairImpulse was = applied(group, from);
  const double share = rule == Rule::Mean ? soft_tune::kRightShare : soft_tune::kRightShareDriven;
  const double allowed = share * std::max(now.size, was.size) + soft_tune::kRightImpulse;
  return norm(now.force - was.force) <= allowed &&
         norm(now.moment - was.moment) <= allowed * std::max(now.lever, soft_tune::kLeastLever);
}

void SoftContacts::look(const System& system, Data& data, double h, bool first) {
  if (active_.empty()) return;
  if (first) body_twists(system.model, data.state.pose.kin, data.state.qvel.data(), twists_);
  for (Group& group : groups_) {
    IslandProgress& progress = data.attempt.islands[island(data, group)];
    if (!progress.open()) continue;
    group.guessed = false;
    // Whatever the budget, layers push: without a first solve their rows would be missing.
    const bool again = progress.pass < soft_tune::kMostLooks && (first || !data.budget.out());
    const bool right =
        !(first && again && guess(system, data, h, group)) && measure(system, data, h, group);
    if (!right && again) progress.violated = true;
  }
}

Vec3 SoftContacts::take_friction(const Group& group) const {
  Vec3 along;
  for (const Contact& c : rows_)
    if (has(group, c.pair)) along += c.impulse - dot(c.impulse, c.n) * c.n;
  return along;
}

void SoftContacts::linearise(const System& system, Data& data, double h,
                             const std::vector<Twist>& twists) {
  for (const Group& group : groups_) {
    if (!data.attempt.islands[island(data, group)].open()) continue;
    const auto its = [&](const Contact& c) { return has(group, c.pair); };
    if (std::any_of(rows_.begin(), rows_.end(), its))
      friction_[pairs_.first_of_group(active_[group.first].pair)] = take_friction(group);
    rows_.erase(std::remove_if(rows_.begin(), rows_.end(), its), rows_.end());
    add_rows(system, data, group, h, twists);
  }
}

// Points are found at the end pose, or guessed, and lie on the bodies where those are at the start.
void SoftContacts::add_rows(const System& system, Data& data, const Group& group, double h,
                            const std::vector<Twist>& twists) {
  const Rule rule = rules_.of(island(data, group));
  GroupRows& its = rows_of(group);
  const Vec3 went = this->went(system, data, group);
  list_pressed(rule, h, went, group);
  if (its.pressed.empty()) return;
  Poses& start = data.state.pose;
  const int first = active_[group.first].pair;
  const bool person = system.world.shapes[pairs_[first].shape].person >= 0;
  its.along = friction_[pairs_.first_of_group(first)];
  its.back = -went;
  const auto parting = [&](const Contact& c) {
    if (group.guessed) return dot(c.n, group.twist.v + cross(group.twist.w, c.position));
    return approach(system.model, start.kin, c, twists, data.step.v);
  };
  maker_.make(system, start, rule, person ? soft_tune::kFirmTurn : 0, its, parting, rows_);
}

void SoftContacts::push_row(const System& system, Data& data, const Contact& c) {
  const ContactCandidate& k = data.attempt.candidates[c.pair];
  const int a = system.tree(k.shape), b = k.other_shape >= 0 ? system.tree(k.other_shape) : 0;
  data.result.disturbed[a] = 1;
  if (b > 0) data.result.disturbed[b] = 1;
  const auto push = [&](int body) { data.step.pushed[body] = 1; };
  for_each_pushed(system, k, push);
  for (const BodyLoad& load : loads_of(c))
    for_each_pushed(system, data.attempt.candidates[load.candidate], push);
  rules_.push(system, data, k.island, a, b, c);
}

// A row of several bodies is recorded as a contact of each.
void SoftContacts::record_row(Data& data, const Contact& c) const {
  Contact whole = c;
  whole.impulse = rules_.whole(data.attempt.candidates[c.pair].island, c);
  if (loads_of(c).empty()) data.result.add(data.attempt.candidates[c.pair], whole);
  for (const BodyLoad& load : loads_of(c)) {
    Contact part = whole;
    part.position = load.x, part.impulse = load.share * whole.impulse;
    data.result.add(data.attempt.candidates[load.candidate], part);
  }
}

// Those of the group of a row; none if it has one body.
const std::vector<BodyLoad>& SoftContacts::loads_of(const Contact& row) const {
  size_t k = 0;
  while (!has(groups_[k], row.pair)) k++;
  return rows_of_[k].loads;
}

// `part`: the step was shortened, and nothing has been looked at where it ends.
void SoftContacts::record_group(const System& system, Data& data, double h, bool part,
                                const Group& group) {
  friction_[pairs_.first_of_group(active_[group.first].pair)] = take_friction(group);
  const int its_island = island(data, group);
  for (int i = group.first; i < group.end; i++) {
    const Entry& e = active_[i];
    SoftPair& pair = pairs_[e.pair];
    if (part) {
      find_depths(system.world, system.soft, data.step.end, SoftPairs::way(system, data, pair),
                  pair);
      find_pressures(rules_.of(its_island), h, pair);
    }
    find_went(h, pair);
    if (data.step.last) record_points(system, data, e);
    if (rules_.balanced(its_island)) rules_.give(its_island, given_back(h, pair));
    remember(system.world, data.step.end, pair, cells_);
  }
}

void SoftContacts::record_points(const System& system, Data& data, const Entry& entry) {
  const SoftPair& pair = pairs_[entry.pair];
  using N = NearSamples;
  const N& near = pair.near;
  for (int i = 0; i < near.size(); i++) {
    const double pressure = near[N::Pressure][i];
    if (!(pressure > 0)) continue;
    const PressedPart part = pressed_part(near, i);
    const Vec3 x = near.vector(N::Hard, i) + near[N::Own][i] * near.vector(N::Normal, i);
    data.result.soft.push_back({pair.other_static, pair.other_shape, pair.shape,
                                system.soft.number(pair.shape, near.sample[i]), x,
                                near.vector(N::Away, i), part.depth, pressure / part.share,
                                near[N::Area][i] * part.share});
  }
}

void SoftContacts::record(const System& system, Data& data, double h,
                          const std::vector<double>& share) {
  if (!any()) return;
  const std::vector<char>& active = system.world.active;
  // What was pressed in the substep before, or an earlier piece of this one.
  std::vector<SoftPoint>& points = data.result.soft;
  const auto moves = [&](int shape) {
    return shape >= 0 && active[system.world.shapes[shape].body];
  };
  points.erase(
      std::remove_if(points.begin(), points.end(),
                     [&](const SoftPoint& p) { return moves(p.shape) || moves(p.layer_shape); }),
      points.end());
  rules_.begin_record(system.model);
  const auto made = [&](int candidate) {
    return share.empty() || share[data.islands.of(system, data.attempt.candidates[candidate])] >= 0;
  };
  for (const Group& group : groups_) {
    GroupRows& its = rows_of(group);
    its.loads.clear();
    if (of_one_body(system, its)) continue;
    list_pressed(rules_.of(island(data, group)), h, went(system, data, group), group);
    find_loads(system, its);
  }
  const auto pushes = [&](const Contact& c) { return norm2(c.impulse) > 0 && made(c.pair); };
  for (const Contact& c : rows_)
    if (pushes(c)) push_row(system, data, c);
  for (const Group& group : groups_)
    if (made(active_[group.first].candidate)) record_group(system, data, h, !share.empty(), group);
  rules_.balance(system, data);
  for (const Contact& c : rows_)
    if (pushes(c)) record_row(data, c);
  rules_.end_record(system, data, share);
}

void SoftContacts::save(std::vector<double>& out) const {
  rules_.save(out);
  for (const Vec3& f : friction_) out.insert(out.end(), {f.x, f.y, f.z});
  cells_.save(out);
}

const double* SoftContacts::load(const double* in) {
  pairs_.forget();
  in = rules_.load(in);
  for (Vec3& f : friction_) f = load3(in), in += 3;
  in = cells_.load(in);
  active_.clear();
  groups_.clear();
  rows_.clear();
  return in;
}

void SoftContacts::adopt(const SoftContacts& old, const std::vector<int>& body,
                         const std::vector<int>& now) {
  if (!any() || !old.any()) return;
  rules_.adopt(old.rules_, body);
  const auto shape = [&](int i) { return i >= 0 ? now[i] : -1; };
  std::map<int64_t, Vec3> known;
  for (int k = 0; k < old.pairs_.size(); k++) {
    const SoftPair& p = old.pairs_[k];
    const PairId id{shape(p.shape), p.other_static, shape(p.other_shape)};
    if (id.shape >= 0 && (id.other_static >= 0 || id.other_shape >= 0))
      known[pair_key(id)] = old.friction_[k];
  }
  for (int k = 0; k < pairs_.size(); k++) {
    const SoftPair& p = pairs_[k];
    const auto found = known.find(pair_key(PairId{p.shape, p.other_static, p.other_shape}));
    if (found != known.end()) friction_[k] = found->second;
  }
  cells_.adopt(old.cells_, now);
}

}  // namespace hp
