#include "stepping/soft_rows.h"

#include <algorithm>

namespace hp {

namespace {

// Carriers' weights times a point whose coordinates are n apart, and their weights.
void weigh(const SurfaceSamples::Carrier* by, int count, const double* x, int n,
           std::vector<SurfaceSamples::Four>& out) {
  out.resize(count);
  for (int e = 0; e < count; e++) {
    const double w = by[e].weight;
    out[e] = {w * x[0], w * x[n], w * x[2 * (size_t)n], w};
  }
}

int body_of(const System& system, const SoftPair* pair) {
  return system.world.shapes[pair->shape].body;
}

}  // namespace

bool of_one_body(const System& system, const GroupRows& group) {
  const int first = body_of(system, group.members.front());
  return std::all_of(group.members.begin(), group.members.end(),
                     [&](const SoftPair* m) { return body_of(system, m) == first; });
}

void find_loads(const System& system, GroupRows& group) {
  std::vector<BodyLoad>& loads = group.loads;
  double sum = 0;
  for (const PressedBlock& p : group.pressed.blocks())
    for (int k = 0; k < PressedBlock::kSize; k++) {
      if (!(p.impulse[k] > 0)) continue;
      const int body = body_of(system, group.members[p.member[k]]);
      const auto its = [&](const BodyLoad& load) { return load.body == body; };
      auto at = std::find_if(loads.begin(), loads.end(), its);
      if (at == loads.end()) at = loads.insert(at, {body, group.candidates[p.member[k]], 0, {}});
      at->share += p.impulse[k], at->x += p.impulse[k] * p.place(k);
      sum += p.impulse[k];
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

void RowMaker::add(const SurfaceSamples::Carrier* by, const SurfaceSamples::Four* weighted,
                   int count, double load) {
  for (int e = 0; e < count; e++) {
    double* sum = carried_[by[e].joint].sum;
    if (sum[3] == 0) joints_.push_back(by[e].joint);
    for (int k = 0; k < 4; k += kLanes) lanes(sum + k) += load * lanes(weighted[e].data() + k);
  }
}

// Sums over the samples of a patch, by their loads, of what joints carry of them. A joint carries a point of a skin at
// rest, r, to R (r - p) + c (collision/skin.h).
void RowMaker::carry(const System& system, Poses& start, const GroupRows& group, int patch) {
  int member = -1, n = 0;
  const SurfaceSamples* samples = nullptr;
  const double* bent = nullptr;  // places at rest, where these depend on the pose
  for (const PressedBlock& p : group.pressed.blocks())
    for (int k = 0; k < PressedBlock::kSize; k++) {
      if (p.patch[k] != patch) continue;
      if (p.member[k] != member) {
        member = p.member[k];
        const int i = group.members[member]->shape;
        const CollisionShape& shape = system.world.shapes[i];
        samples = &system.soft.samples_of(i);
        n = (int)shape.vertex.size();
        const bool bends = !shape.blend_bounds.empty();
        bent = bends ? system.world.place(start, i).rest.data() : nullptr;
      }
      const int s = p.sample[k], first = samples->first_carrier[s];
      const int count = samples->first_carrier[s + 1] - first;
      const SurfaceSamples::Four* weighted = &samples->weighted[first];
      if (bent) {
        weigh(samples->carriers.data() + first, count, bent + samples->vertex[s], n, weighted_);
        weighted = weighted_.data();
      }
      add(samples->carriers.data() + first, weighted, count, p.load[k]);
    }
}

// The mean of the points that the samples of a patch are, moved to x: sums of weights and of weighted places at
// rest say where a joint carries the mean.
Endpoint RowMaker::mean_point(const System& system, Poses& start, const GroupRows& group, int patch,
                              Vec3 x) {
  const Skin& skin = *system.world.shapes[group.members[0]->shape].skin;
  carried_.resize(std::max(carried_.size(), skin.joint.size()));
  joints_.clear();
  carry(system, start, group, patch);
  double all = 0;
  Vec3 middle;
  for (const int j : joints_) {
    Carried& its = carried_[j];
    const int b = skin.body[j];
    its.at = start.kin.xpos[b] +
             start.kin.xmat[b] * ((1 / its.weight()) * load3(its.sum) - skin.joint[j]);
    all += its.weight(), middle += its.weight() * its.at;
  }
  middle = (1 / all) * middle;
  const auto heavier = [&](int a, int b) { return carried_[a].weight() > carried_[b].weight(); };
  std::stable_sort(joints_.begin(), joints_.end(), heavier);
  Endpoint out;
  out.count = std::min((int)joints_.size(), Endpoint::kMost);
  double kept = 0;
  for (int k = 0; k < out.count; k++) kept += carried_[joints_[k]].weight();
  for (int k = 0; k < out.count; k++) {
    const Carried& its = carried_[joints_[k]];
    out.body[k] = skin.body[joints_[k]], out.weight[k] = its.weight() / kept;
    out.point[k] = its.at + (x - middle);
  }
  for (const int j : joints_) carried_[j] = {};
  return out;
}

}  // namespace hp
