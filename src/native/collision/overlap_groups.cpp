#include "collision/overlap_groups.h"

#include <cmath>
#include <numeric>

#include "tuning.h"

namespace hp {

namespace tune = tuning::collision;

namespace {

// Disjoint sets of bodies.
struct BodySets {
  std::vector<int> parent;
  explicit BodySets(int bodies) : parent(bodies) { std::iota(parent.begin(), parent.end(), 0); }
  int find(int b) {
    while (parent[b] != b) b = parent[b] = parent[parent[b]];
    return b;
  }
  void join(int a, int b) { parent[find(a)] = find(b); }
};

// Bodies that bones connect without crossing the obstacle.
BodySets connected_parts(const Model& m, const Kinematics& kin, const Obstacle& o, int root,
                         size_t& tests) {
  BodySets parts(m.nbody);
  for (int b = 1; b < m.nbody; b++) {
    if (m.root[b] != root || b == root) continue;
    const int p = m.parent[b];
    if (!o.crosses(kin.xpos[p], kin.xpos[b], tests)) parts.join(b, p);
  }
  return parts;
}

// The part that is on the right side of the obstacle.
int main_part(const Model& m, const Kinematics& kin, const Obstacle& o, int root, BodySets& parts) {
  std::vector<double> mass(m.nbody, 0);
  int main = parts.find(root);
  double all = 0, least = 1e300;
  for (int b = 1; b < m.nbody; b++)
    if (m.root[b] == root) mass[parts.find(b)] += m.mass[b], all += m.mass[b];
  for (int b = 1; b < m.nbody; b++) {
    if (m.root[b] != root || mass[b] <= tune::kGreaterPart * all) continue;
    const double within =
        o.is(Static::Kind::Mesh) ? std::round(o.fixed->tree->winding(kin.xpos[b])) : 0;
    if (within < least || (within == least && mass[b] > mass[main])) least = within, main = b;
  }
  return main;
}

}  // namespace

std::vector<OverlapGroup> overlap_groups(const CollisionWorld& world, const Model& m, Poses& start,
                                         const Obstacle& o, int root,
                                         const std::vector<int>& overlapping, size_t& tests) {
  const std::vector<CollisionShape>& shapes = world.shapes;
  BodySets parts = connected_parts(m, start.kin, o, root, tests), groups(m.nbody);
  const int main = main_part(m, start.kin, o, root, parts);
  std::vector<char> in(shapes.size(), 0), body_in(m.nbody, 0);
  for (int i : overlapping) in[i] = 1;
  for (size_t i = 0; i < shapes.size(); i++) {
    const int b = shapes[i].body;
    if (m.root[b] != root || world.pairing(shapes[i].name, o.name).ignore) continue;
    if (o.fixed && parts.find(b) != main) in[i] = 1;
    if (in[i]) body_in[b] = 1;
  }
  for (int b = 1; b < m.nbody; b++)
    if (body_in[b] && b != root && body_in[m.parent[b]]) groups.join(b, m.parent[b]);
  std::vector<OverlapGroup> found;
  for (int g = 1; g < m.nbody; g++) {
    if (!body_in[g] || groups.find(g) != g) continue;
    OverlapGroup group{{}, std::vector<char>(m.nbody, 0), std::vector<char>(m.nbody, 0)};
    for (size_t i = 0; i < shapes.size(); i++)
      if (in[i] && groups.find(shapes[i].body) == g) group.shapes.push_back((int)i);
    for (int b = 1; b < m.nbody; b++) {
      group.moves[b] = body_in[b] && groups.find(b) == g;
      group.stays[b] = parts.find(b) == main;
    }
    found.push_back(std::move(group));
  }
  return found;
}

}  // namespace hp
