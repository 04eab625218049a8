#include "stepping/soft_rows.h"

#include <algorithm>

namespace hp {

void find_loads(const System& system, GroupRows& group) {
  const auto body_of = [&](const SoftPair* pair) { return system.world.shapes[pair->shape].body; };
  const auto alike = [&](const SoftPair* m) {
    return body_of(m) == body_of(group.members.front());
  };
  std::vector<BodyLoad>& loads = group.loads;
  loads.clear();
  if (std::all_of(group.members.begin(), group.members.end(), alike)) return;
  double sum = 0;
  for (const PressedSample& p : group.pressed) {
    const int body = body_of(group.members[p.member]);
    const auto its = [&](const BodyLoad& load) { return load.body == body; };
    auto at = std::find_if(loads.begin(), loads.end(), its);
    if (at == loads.end()) at = loads.insert(at, {body, group.candidates[p.member], 0, {}});
    at->share += p.impulse, at->x += p.impulse * p.x;
    sum += p.impulse;
  }
  for (BodyLoad& load : loads) load.x = (1 / load.share) * load.x, load.share /= sum;
}

Contact RowMaker::row(const System& system, Poses& start, Rule rule, const GroupRows& group,
                      const PatchPoint& point) {
  const World& world = system.world;
  const SoftPair& pair = *group.members[point.member];
  const CollisionShape& shape = world.shapes[pair.shape];
  const int other = pair.other_shape >= 0 ? world.shapes[pair.other_shape].body : 0;
  const int other_name = pair.other_shape >= 0 ? world.shapes[pair.other_shape].name
                                               : world.statics[pair.other_static].name;
  Contact c;
  c.n = point.n;
  tangents(c.n, c.t, c.s);
  c.position = c.at_a = c.at_b = point.x + group.back;
  c.a = shape.skin ? mean_point(system, start, group, point.patch, c.position)
                   : Endpoint::rigid(shape.body, c.position);
  c.b = Endpoint::rigid(other, c.position);
  c.friction = world.pairing(shape.name, other_name).friction / moving_share(rule);
  const Vec3 along = (1.0 / (double)points_.size()) * group.along;
  c.impulse = point.impulse * c.n + along - dot(along, c.n) * c.n;
  c.pair = group.candidates[point.member];
  c.key = pair_key(PairId{pair.shape, pair.other_static, pair.other_shape});
  return c;
}

// The mean of the points that the samples of a patch are, moved to x. A joint carries a point of a skin at
// rest, r, to R (r - p) + c (collision/skin.h): sums of weights and of weighted r say where it carries the
// mean.
Endpoint RowMaker::mean_point(const System& system, Poses& start, const GroupRows& group, int patch,
                              Vec3 x) {
  const World& world = system.world;
  const Skin& skin = *world.shapes[group.members[0]->shape].skin;
  carried_.resize(std::max(carried_.size(), skin.joint.size()));
  joints_.clear();
  double all = 0;
  Vec3 middle;
  int member = -1, n = 0;
  const SurfaceSamples* samples = nullptr;
  const double* rest = nullptr;
  for (const PressedSample& p : group.pressed) {
    if (p.patch != patch) continue;
    if (p.member != member) {
      member = p.member;
      const int i = group.members[member]->shape;
      const CollisionShape& shape = world.shapes[i];
      samples = &system.soft.samples_of(i);
      n = (int)shape.vertex.size();
      const bool bends = !shape.blend_bounds.empty();
      rest = bends ? world.place(start, i).rest.data() : nullptr;
    }
    const int s = p.sample, at = samples->vertex[s];
    const Vec3 r = rest ? Vec3{rest[at], rest[n + at], rest[2 * n + at]} : samples->points[s];
    all += p.load;
    for (int e = samples->first_carrier[s]; e < samples->first_carrier[s + 1]; e++) {
      const SurfaceSamples::Carrier& by = samples->carriers[e];
      Carried& its = carried_[by.joint];
      if (its.weight == 0) joints_.push_back(by.joint);
      const double weight = p.load * by.weight;
      its.weight += weight, its.rest += weight * r;
    }
  }
  for (const int j : joints_) {
    Carried& its = carried_[j];
    const int b = skin.body[j];
    its.at = start.kin.xpos[b] + start.kin.xmat[b] * ((1 / its.weight) * its.rest - skin.joint[j]);
    middle += (its.weight / all) * its.at;
  }
  const auto heavier = [&](int a, int b) { return carried_[a].weight > carried_[b].weight; };
  std::stable_sort(joints_.begin(), joints_.end(), heavier);
  Endpoint out;
  out.count = std::min((int)joints_.size(), Endpoint::kMost);
  double kept = 0;
  for (int k = 0; k < out.count; k++) kept += carried_[joints_[k]].weight;
  for (int k = 0; k < out.count; k++) {
    const Carried& its = carried_[joints_[k]];
    out.body[k] = skin.body[joints_[k]], out.weight[k] = its.weight / kept;
    out.point[k] = its.at + (x - middle);
  }
  for (const int j : joints_) carried_[j] = {};
  return out;
}

}  // namespace hp
