#include "stepping/soft_contacts.h"

#include <algorithm>
#include <map>

#include "stepping/data.h"
#include "stepping/untouched_joints.h"
#include "tuning.h"

namespace hp {

namespace tune = tuning::soft;

void SoftContacts::finish(const System& system) {
  pairs_.clear();
  if (system.soft.any()) {
    const World& world = system.world;
    for (int i = 0; i < (int)world.shapes.size(); i++) {
      for (int k = 0; k < (int)world.statics.size(); k++)
        if (!world.pairing(world.shapes[i].name, world.statics[k].name).ignore)
          list_pair(system, i, k, -1);
      for (int j = 0; j < i; j++)
        if (system.tree(i) != system.tree(j) && world.may_touch(system.model, i, j))
          chooses_first(system, i, j) ? list_pair(system, i, -1, j) : list_pair(system, j, -1, i);
    }
  }
  reset(system.model);
}

// Of two shapes, a person's samples press, else those of the smaller one, if there are any.
bool SoftContacts::chooses_first(const System& system, int a, int b) const {
  const SoftWorld& soft = system.soft;
  const CollisionShape &A = system.world.shapes[a], &B = system.world.shapes[b];
  const bool has_a = soft.samples_of(a).size() > 0, has_b = soft.samples_of(b).size() > 0;
  if (has_a != has_b) return has_a;
  if ((A.person >= 0) != (B.person >= 0)) return A.person >= 0;
  return A.hull.bound <= B.hull.bound;
}

void SoftContacts::list_pair(const System& system, int shape, int other_static, int other_shape) {
  const SurfaceSamples& samples = system.soft.samples_of(shape);
  const SoftLayer& layer = other_static >= 0 ? system.soft.layer_of_static(other_static)
                                             : system.soft.layer_of_shape(other_shape);
  SoftPair pair;
  pair.shape = shape, pair.other_static = other_static, pair.other_shape = other_shape;
  pair.thickness = samples.thickest + layer.thickness;
  if (samples.size() > 0 && pair.thickness > 0) pairs_.push_back(pair);
}

void SoftContacts::reset(const Model& m) {
  for (SoftPair& pair : pairs_) pair.forget();
  friction_.assign(pairs_.size(), {});
  level_.assign(any() ? m.nbody : 0, 0);
  cells_.clear();
  active_.clear();
  rows_.clear();
  kick_.assign(any() ? m.nv : 0, 0);
}

// The shape is at least this far off the frame, by its bounding sphere.
double SoftContacts::room(const System& system, Poses& start, const SoftPair& pair,
                          double range) const {
  const std::vector<CollisionShape>& shapes = system.world.shapes;
  const BoundingSphere a = start.cached_bounding_sphere(shapes, pair.shape);
  if (pair.other_shape >= 0) {
    const BoundingSphere b = start.cached_bounding_sphere(shapes, pair.other_shape);
    return norm(a.center - b.center) - a.radius - b.radius;
  }
  FramePoint p;
  const FrameDistance frame =
      FrameDistance::of_static(system.world, system.soft, pair.other_static);
  return (frame.nearest(a.center, range + a.radius, -1, p) ? p.distance : range + a.radius) -
         a.radius;
}

// May a point of the shape come within the pair's layers, if they travel `reach` toward each other?
bool SoftContacts::near(const System& system, Data& data, SoftPair& pair, double reach) {
  const double range = pair.thickness + reach;
  if (pair.other_shape >= 0) return room(system, data.state.pose, pair, 0) < range;
  const double travelled = system.world.broad_phase.travelled(pair.shape);
  if (pair.room < 0 || pair.room - (travelled - pair.room_at) < range) {
    pair.room = std::max(0.0, room(system, data.state.pose, pair, range + tune::kRoomMargin));
    pair.room_at = travelled;
  }
  return pair.room < range;
}

bool SoftContacts::takes_part(const System& system, const SoftPair& pair) const {
  BroadPhasePair e;
  e.shape = pair.shape, e.other_static = pair.other_static, e.other_shape = pair.other_shape;
  return system.world.takes_part(e);
}

void SoftContacts::mark_busy(const System& system, Data& data, const std::vector<double>& travel,
                             std::vector<char>& busy) {
  for (SoftPair& pair : pairs_) {
    const int a = system.tree(pair.shape);
    const int b = pair.other_shape >= 0 ? system.tree(pair.other_shape) : a;
    if (busy[a] && busy[b]) continue;
    const double way = travel[pair.shape] + (pair.other_shape >= 0 ? travel[pair.other_shape] : 0);
    if (near(system, data, pair, way)) busy[a] = busy[b] = 1;
  }
}

void SoftContacts::ease_gravity(const System& system, Data& data, double h) const {
  if (!any() || data.step.host_v_free) return;
  for (const int b : system.objects)
    if (level_[b] && system.world.active[b] && !system.world.asleep[b] && !system.model.held[b])
      for (int i = 0; i < 3; i++)
        data.step.v_free[system.model.dof_first[b] + i] -= 0.5 * h * system.gravity[i];
}

void SoftContacts::gather(const System& system, Data& data) {
  active_.clear();
  rows_.clear();
  if (!any()) return;
  Attempt& attempt = data.attempt;
  Poses& start = data.state.pose;
  for (int k = 0; k < (int)pairs_.size(); k++) {
    SoftPair& pair = pairs_[k];
    if (!takes_part(system, pair)) continue;
    const double reach =
        attempt.reach[pair.shape] + (pair.other_shape >= 0 ? attempt.reach[pair.other_shape] : 0);
    if (!near(system, data, pair, reach)) continue;
    if (pair.stamp != start.stamp || pair.reach < reach) {
      find_near(system.world, system.soft, cells_, start, reach, travelled(system, pair), pair);
      data.budget.spend(tune::kSampleWork * system.soft.samples_of(pair.shape).size());
    }
    if (pair.near.empty()) continue;
    ContactCandidate c;
    c.shape = pair.shape, c.other_static = pair.other_static, c.other_shape = pair.other_shape;
    c.soft = k;
    active_.push_back({k, (int)attempt.candidates.size()});
    attempt.candidates.push_back(c);
  }
}

void SoftContacts::choose_rules(const System& system, Data& data, double h) {
  if (active_.empty()) return;
  const Model& model = system.model;
  rules_.assign(model.nbody, data.step.host_v_free ? Rule::End : Rule::Mean);
  std::vector<char> free(model.nbody, 0);
  for (const int b : system.objects) free[b] = !model.held[b];
  for (int b = 1; b < model.nbody; b++) {
    if (model.root[b] != b) continue;
    const int island = data.islands.of_tree(b);
    if (!free[b] || data.attempt.islands[island].violated) rules_[island] = Rule::End;
  }
  for (const Entry& e : active_) {
    Rule& by = rules_[data.attempt.candidates[e.candidate].island];
    if (by == Rule::Mean && stiff(system, data, pairs_[e.pair], h)) by = Rule::End;
  }
}

// How far the two have gone toward each other to the end pose, and since the start of all, at most [m].
double SoftContacts::way(const System& system, Data& data, const SoftPair& pair) {
  const std::vector<double>& way = data.step.way(system, data.state);
  return way[pair.shape] + (pair.other_shape >= 0 ? way[pair.other_shape] : 0);
}

double SoftContacts::travelled(const System& system, const SoftPair& pair) {
  const BroadPhase& all = system.world.broad_phase;
  return all.travelled(pair.shape) + (pair.other_shape >= 0 ? all.travelled(pair.other_shape) : 0);
}

// Is an object's bounce on the layer too fast for a step of h, where v* takes it?
bool SoftContacts::stiff(const System& system, Data& data, SoftPair& pair, double h) const {
  if (!find_depths(system.world, system.soft, data.step.end, way(system, data, pair), pair))
    return false;
  find_pressures(Rule::End, h, pair);
  double firmness = 0;  // h^2 times the stiffness
  for (const NearSample& s : pair.near) firmness += h * h * s.area * s.slope;
  double mass = system.model.mass[system.world.shapes[pair.shape].body];
  if (pair.other_shape >= 0)
    mass = std::min(mass, system.model.mass[system.world.shapes[pair.other_shape].body]);
  return firmness > tune::kStiffBounce * mass;
}

Rule SoftContacts::rule(const Data& data, int candidate) const {
  return rules_[data.attempt.candidates[candidate].island];
}

Vec3 SoftContacts::middle(const System& system, Poses& pose, const SoftPair& pair) const {
  return pose.cached_bounding_sphere(system.world.shapes, pair.shape).center;
}

// What the rows of a candidate have exerted along their normals.
PairImpulse SoftContacts::applied(int candidate, Vec3 about) const {
  PairImpulse sum;
  for (const Contact& c : rows_) {
    if (c.pair != candidate) continue;
    const double q = dot(c.impulse, c.n);
    sum.force += q * c.n;
    sum.moment += q * cross(c.position - about, c.n);
    sum.size += q;
  }
  return sum;
}

void SoftContacts::look(const System& system, Data& data, double h) {
  Attempt& attempt = data.attempt;
  Poses &start = data.state.pose, &end = data.step.end;
  for (const Entry& e : active_) {
    IslandProgress& island = attempt.islands[attempt.candidates[e.candidate].island];
    if (!island.open()) continue;
    SoftPair& pair = pairs_[e.pair];
    find_depths(system.world, system.soft, end, way(system, data, pair), pair);
    data.budget.spend(tune::kSampleWork * (double)pair.near.size());
    const Vec3 from = middle(system, start, pair), to = middle(system, end, pair);
    if (rule(data, e.candidate) == Rule::Mean) act_between(from, to, pair);
    find_pressures(rule(data, e.candidate), h, pair);
    const PairImpulse now = total_impulse(pair, rule(data, e.candidate), h, to);
    // The rows lie where the layer was when they were made.
    const PairImpulse was = applied(e.candidate, from);
    const double size = std::max(now.size, was.size);
    const bool free = rule(data, e.candidate) == Rule::Mean;
    const double share = free ? tune::kRightShare : tune::kRightShareDriven;
    const double allowed = share * size + tune::kRightImpulse;
    const bool wrong =
        norm(now.force - was.force) > allowed ||
        norm(now.moment - was.moment) > allowed * std::max(now.lever, tune::kLeastLever);
    if (wrong && island.pass < tune::kMostLooks && !data.budget.out()) island.violated = true;
  }
}

void SoftContacts::linearise(const System& system, Data& data, double h,
                             const std::vector<Twist>& twists) {
  if (active_.empty()) return;
  const Attempt& attempt = data.attempt;
  const auto open = [&](int candidate) {
    return attempt.islands[attempt.candidates[candidate].island].open();
  };
  for (const Entry& e : active_) {
    if (!open(e.candidate)) continue;
    Vec3 along;
    bool had = false;
    for (const Contact& c : rows_)
      if (c.pair == e.candidate) had = true, along += c.impulse - dot(c.impulse, c.n) * c.n;
    if (had) friction_[e.pair] = along;
    rows_.erase(std::remove_if(rows_.begin(), rows_.end(),
                               [&](const Contact& c) { return c.pair == e.candidate; }),
                rows_.end());
    add_rows(system, data, e, h, twists);
  }
}

namespace {

// The mean of the points that the samples of a patch are, moved to x.
Endpoint mean_point(const World& world, const SoftWorld& soft, Poses& pose, const SoftPair& pair,
                    const std::vector<int>& patch, int index, Vec3 x) {
  const CollisionShape& shape = world.shapes[pair.shape];
  if (!shape.skin) return Endpoint::rigid(shape.body, x);
  const PosedShape& posed = world.place(pose, pair.shape);
  const SurfaceSamples& samples = soft.samples_of(pair.shape);
  std::vector<int> body;
  std::vector<double> weight;
  std::vector<Vec3> point;
  double all = 0;
  Vec3 middle;
  for (size_t i = 0; i < pair.near.size(); i++) {
    const NearSample& s = pair.near[i];
    if (patch[i] != index) continue;
    const double load = s.area * s.pressure;
    const Endpoint e = pose.endpoint(shape, posed, {samples.vertex[s.sample], {}});
    all += load, middle += load * posed.points().at(samples.vertex[s.sample]);
    for (int k = 0; k < e.count; k++) {
      size_t at = 0;
      while (at < body.size() && body[at] != e.body[k]) at++;
      if (at == body.size()) body.push_back(e.body[k]), weight.push_back(0), point.emplace_back();
      weight[at] += load * e.weight[k];
      point[at] += load * e.weight[k] * e.point[k];
    }
  }
  middle = (1 / all) * middle;
  std::vector<int> order(body.size());
  for (size_t k = 0; k < order.size(); k++) order[k] = (int)k;
  std::stable_sort(order.begin(), order.end(), [&](int i, int j) { return weight[i] > weight[j]; });
  Endpoint out;
  out.count = std::min((int)order.size(), Endpoint::kMost);
  double kept = 0;
  for (int k = 0; k < out.count; k++) kept += weight[order[k]];
  for (int k = 0; k < out.count; k++) {
    const int o = order[k];
    out.body[k] = body[o], out.weight[k] = weight[o] / kept;
    out.point[k] = (1 / weight[o]) * point[o] + (x - middle);
  }
  return out;
}

}  // namespace

// Points are found at the end pose and lie on the bodies where those are at the start.
void SoftContacts::add_rows(const System& system, Data& data, const Entry& entry, double h,
                            const std::vector<Twist>& twists) {
  const World& world = system.world;
  const SoftPair& pair = pairs_[entry.pair];
  const Rule by = rule(data, entry.candidate);
  points_.clear();
  condense(pair, by, h, world.shapes[pair.shape].person >= 0 ? tune::kFirmTurn : 0, points_,
           patch_);
  if (points_.empty()) return;
  Poses &start = data.state.pose, &end = data.step.end;
  const CollisionShape& shape = world.shapes[pair.shape];
  const int other = pair.other_shape >= 0 ? world.shapes[pair.other_shape].body : 0;
  const Vec3 back = middle(system, start, pair) - middle(system, end, pair);
  const Pairing& pairing =
      world.pairing(shape.name, pair.other_shape >= 0 ? world.shapes[pair.other_shape].name
                                                      : world.statics[pair.other_static].name);
  const Vec3 along = (1.0 / points_.size()) * friction_[entry.pair];
  for (const PatchPoint& p : points_) {
    Contact c;
    c.n = p.n;
    tangents(c.n, c.t, c.s);
    c.position = c.at_a = c.at_b = p.x + back;
    c.a = mean_point(world, system.soft, start, pair, patch_, p.patch, c.position);
    c.b = Endpoint::rigid(other, c.position);
    c.friction = pairing.friction / moving_share(by);
    c.compliance = 1 / p.yield;
    c.yielding = approach(system.model, start.kin, c, twists, data.step.v) + p.impulse / p.yield;
    c.impulse = p.impulse * c.n + along - dot(along, c.n) * c.n;
    c.pair = entry.candidate;
    c.key = pair_key(data.attempt.candidates[entry.candidate]);
    rows_.push_back(c);
  }
}

void SoftContacts::record_row(const System& system, Data& data, const Contact& c) {
  const ContactCandidate& k = data.attempt.candidates[c.pair];
  const int a = system.tree(k.shape), b = k.other_shape >= 0 ? system.tree(k.other_shape) : 0;
  data.result.disturbed[a] = 1;
  if (b > 0) data.result.disturbed[b] = 1;
  for_each_pushed(system, k, [&](int body) { data.step.pushed[body] = 1; });
  Contact whole = c;
  const double q = dot(c.impulse, c.n);
  const bool mean = rule(data, c.pair) == Rule::Mean;
  for (const int root : {a, b}) pressed_[root] = mean ? Pressed::ByMean : Pressed::ByEnd;
  if (mean) {
    whole.impulse += q * c.n;
    for (const auto& [end, sign] : {std::pair{&c.a, q}, std::pair{&c.b, -q}}) {
      if (end->count == 0) continue;
      const int body = end->body[0], d = system.model.dof_first[body];
      const Kinematics& kin = data.state.pose.kin;
      const Vec3 force = sign * c.n;
      const Vec3 moment = mul_t(kin.xmat[body], cross(end->point[0] - kin.xpos[body], force));
      for (int i = 0; i < 3; i++) force_[d + i] += force[i], force_[d + 3 + i] += moment[i];
    }
  }
  data.result.add(k, whole);
}

void SoftContacts::record_points(const System& system, Data& data, const Entry& entry) {
  const SoftPair& pair = pairs_[entry.pair];
  for (const NearSample& s : pair.near) {
    if (!(s.pressure > 0)) continue;
    const PressedPart part = pressed_part(s);
    data.result.soft.push_back({pair.other_static, pair.other_shape, pair.shape,
                                system.soft.number(pair.shape, s.sample), s.x, s.n, part.depth,
                                s.pressure / part.share, s.area * part.share});
  }
}

void SoftContacts::record(const System& system, Data& data, double h,
                          const std::vector<double>& share) {
  if (!any()) return;
  const Model& model = system.model;
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
  pressed_.assign(model.nbody, Pressed::No);
  force_.assign(model.nv, 0.0);
  const auto made = [&](int candidate) {
    return share.empty() || share[data.islands.of(system, data.attempt.candidates[candidate])] >= 0;
  };
  for (const Contact& c : rows_)
    if (norm2(c.impulse) > 0 && made(c.pair)) record_row(system, data, c);
  for (const Entry& e : active_) {
    if (!made(e.candidate)) continue;
    Vec3 along;
    for (const Contact& c : rows_)
      if (c.pair == e.candidate) along += c.impulse - dot(c.impulse, c.n) * c.n;
    friction_[e.pair] = along;
    if (!share.empty()) {
      find_depths(system.world, system.soft, data.step.end, way(system, data, pairs_[e.pair]),
                  pairs_[e.pair]);
      find_pressures(rule(data, e.candidate), h, pairs_[e.pair]);
    }
    record_points(system, data, e);
    remember(system.world, data.step.end, h, pairs_[e.pair], cells_);
  }
  add_kick(system, data, share);
}

// The other half of impulses and of gravity, of trees that have begun their step.
void SoftContacts::add_kick(const System& system, Data& data, const std::vector<double>& share) {
  const Model& model = system.model;
  const auto by_mean = [](Pressed p) { return p == Pressed::ByMean; };
  kick_.assign(model.nv, 0.0);
  if (std::any_of(pressed_.begin(), pressed_.end(), by_mean)) {
    kick_ = force_;
    data.inertia.solve(model, kick_.data());
  }
  const double half = 0.5 * data.step.gravity_time;
  for (const int b : system.objects) {
    if (!system.world.active[b] || model.held[b] || (!share.empty() && share[b] < 0)) continue;
    if (by_mean(pressed_[b]) || (level_[b] && pressed_[b] == Pressed::ByEnd))
      for (int i = 0; i < 3; i++) kick_[model.dof_first[b] + i] += half * system.gravity[i];
    level_[b] = by_mean(pressed_[b]);
  }
}

void SoftContacts::save(std::vector<double>& out) const {
  out.insert(out.end(), level_.begin(), level_.end());
  for (const Vec3& f : friction_) out.insert(out.end(), {f.x, f.y, f.z});
  cells_.save(out);
}

const double* SoftContacts::load(const double* in) {
  for (SoftPair& pair : pairs_) pair.forget();
  level_.assign(in, in + level_.size());
  in += level_.size();
  for (Vec3& f : friction_) f = load3(in), in += 3;
  in = cells_.load(in);
  active_.clear();
  rows_.clear();
  return in;
}

void SoftContacts::adopt(const SoftContacts& old, const std::vector<int>& body,
                         const std::vector<int>& now) {
  if (!any() || !old.any()) return;
  for (size_t b = 0; b < body.size(); b++) level_[b] = body[b] >= 0 ? old.level_[body[b]] : 0;
  const auto shape = [&](int i) { return i >= 0 ? now[i] : -1; };
  std::map<int64_t, Vec3> known;
  for (size_t k = 0; k < old.pairs_.size(); k++) {
    const SoftPair& p = old.pairs_[k];
    const PairId id{shape(p.shape), p.other_static, shape(p.other_shape)};
    if (id.shape >= 0 && (id.other_static >= 0 || id.other_shape >= 0))
      known[pair_key(id)] = old.friction_[k];
  }
  for (size_t k = 0; k < pairs_.size(); k++) {
    const auto found = known.find(
        pair_key(PairId{pairs_[k].shape, pairs_[k].other_static, pairs_[k].other_shape}));
    if (found != known.end()) friction_[k] = found->second;
  }
  cells_.adopt(old.cells_, now);
}

}  // namespace hp
