#include "stepping/soft_pairs.h"

#include <algorithm>
#include <array>
#include <map>

#include "stepping/data.h"
#include "tuning.h"

namespace hp {

namespace soft_tune = tuning::soft;

namespace {

// Of two shapes, do the samples of the first one press?
bool first_presses(const System& system, int a, int b) {
  const SoftWorld& soft = system.soft;
  const CollisionShape &A = system.world.shapes[a], &B = system.world.shapes[b];
  const bool has_a = soft.samples_of(a).size() > 0, has_b = soft.samples_of(b).size() > 0;
  if (has_a != has_b) return has_a;
  if ((A.person >= 0) != (B.person >= 0)) return A.person >= 0;
  return A.hull.bound <= B.hull.bound;
}

// The shape is at least this far off the frame, by its bounding sphere.
double room(const System& system, Poses& start, const SoftPair& pair, double range) {
  const std::vector<CollisionShape>& shapes = system.world.shapes;
  const BoundingSphere a = start.cached_bounding_sphere(shapes, pair.shape);
  if (pair.other_shape >= 0) {
    const BoundingSphere b = start.cached_bounding_sphere(shapes, pair.other_shape);
    return norm(a.center - b.center) - a.radius - b.radius;
  }
  FramePoint p;
  const FrameDistance frame =
      FrameDistance::of_static(system.world, system.soft, pair.other_static);
  if (frame.nearest(a.center, range + a.radius, -1, p)) return p.distance - a.radius;
  // A middle within a box, of a hull that it is no point of.
  return frame.holds(a.center) ? -a.radius : range;
}

// A person's skin presses by its samples: hulls that have none of them are pressed by nothing, as their
// neighbours' samples are where they are.
bool pressed_by_samples(const System& system, const std::vector<char>& sampled, int shape) {
  const int person = system.world.shapes[shape].person;
  return person >= 0 && sampled[person];
}

// Per person: does its skin have samples?
std::vector<char> sampled_people(const System& system) {
  std::vector<char> out(system.drives.size(), 0);
  const std::vector<CollisionShape>& shapes = system.world.shapes;
  for (size_t i = 0; i < shapes.size(); i++)
    if (shapes[i].person >= 0 && system.soft.samples_of((int)i).size() > 0)
      out[shapes[i].person] = 1;
  return out;
}

}  // namespace

void SoftPairs::finish(const System& system) {
  all_.clear();
  if (system.soft.any()) {
    const World& world = system.world;
    const std::vector<char> sampled = sampled_people(system);
    auto press = [&](int shape, int other) {
      const bool own = system.world.shapes[shape].person >= 0;
      if (own || !pressed_by_samples(system, sampled, other)) list(system, shape, -1, other);
    };
    for (int i = 0; i < (int)world.shapes.size(); i++) {
      for (int k = 0; k < (int)world.statics.size(); k++)
        if (!world.pairing(world.shapes[i].name, world.statics[k].name).ignore)
          list(system, i, k, -1);
      for (int j = 0; j < i; j++)
        if (system.tree(i) != system.tree(j) && world.may_touch(system.model, i, j))
          first_presses(system, i, j) ? press(i, j) : press(j, i);
    }
  }
  find_groups(system);
}

void SoftPairs::list(const System& system, int shape, int other_static, int other_shape) {
  const SurfaceSamples& samples = system.soft.samples_of(shape);
  const SoftLayer& layer = other_static >= 0 ? system.soft.layer_of_static(other_static)
                                             : system.soft.layer_of_shape(other_shape);
  SoftPair pair;
  pair.shape = shape, pair.other_static = other_static, pair.other_shape = other_shape;
  pair.thickness = samples.thickest + layer.thickness;
  if (samples.size() > 0 && pair.thickness > 0) all_.push_back(pair);
}

namespace {

// The body whose rows those of a shape on a static layer are: its own, or of a small part the nearest that is not.
int bearing_body(const System& system, int shape) {
  const Model& m = system.model;
  int body = system.world.shapes[shape].body;
  const double least = soft_tune::kSmallPart * m.carried[m.root[body]];
  while (m.mass[body] < least && body != m.root[body]) body = m.parent[body];
  return body;
}

}  // namespace

void SoftPairs::find_groups(const System& system) {
  std::map<std::array<int, 4>, int> known;
  first_.clear();
  for (int k = 0; k < size(); k++) {
    SoftPair& pair = all_[k];
    const CollisionShape& shape = system.world.shapes[pair.shape];
    // The hulls of an object may be apart, and differ in friction.
    const int apart = shape.person >= 0 ? -1 : pair.shape;
    const bool bears = shape.person >= 0 && pair.other_static >= 0;
    const int body = bears ? bearing_body(system, pair.shape) : shape.body;
    const auto [at, added] =
        known.insert({{body, apart, pair.other_static, pair.other_shape}, (int)first_.size()});
    if (added) first_.push_back(k);
    pair.group = at->second;
  }
  groups_ = (int)first_.size();
}

void SoftPairs::forget() {
  for (SoftPair& pair : all_) pair.forget();
}

bool SoftPairs::near(const System& system, Data& data, SoftPair& pair, double reach) {
  const double range = pair.thickness + reach;
  if (pair.other_shape >= 0) return room(system, data.state.pose, pair, 0) < range;
  const double gone = system.world.broad_phase.travelled(pair.shape);
  if (pair.room < 0 || pair.room - (gone - pair.room_at) < range) {
    pair.room = std::max(0.0, room(system, data.state.pose, pair, range + soft_tune::kRoomMargin));
    pair.room_at = gone;
  }
  return pair.room < range;
}

bool SoftPairs::takes_part(const System& system, const SoftPair& pair) {
  BroadPhasePair e;
  e.shape = pair.shape, e.other_static = pair.other_static, e.other_shape = pair.other_shape;
  return system.world.takes_part(e);
}

double SoftPairs::way(const System& system, Data& data, const SoftPair& pair) {
  const std::vector<double>& way = data.step.way(system, data.state);
  return way[pair.shape] + (pair.other_shape >= 0 ? way[pair.other_shape] : 0);
}

double SoftPairs::travelled(const System& system, const SoftPair& pair) {
  const BroadPhase& all = system.world.broad_phase;
  return all.travelled(pair.shape) + (pair.other_shape >= 0 ? all.travelled(pair.other_shape) : 0);
}

}  // namespace hp
