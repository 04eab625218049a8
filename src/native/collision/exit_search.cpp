#include "collision/exit_search.h"

#include "tuning.h"

namespace hp {

namespace tune = tuning::collision;

ExitSearch::ExitSearch(const CollisionWorld& world, const Model& m, Poses& start, const Obstacle& o,
                       const OverlapGroup& group, Vec3 avoid, size_t most_tests, size_t& tests)
    : world_(world),
      model_(m),
      start_(start),
      obstacle_(o),
      group_(group),
      avoid_(avoid),
      most_tests_(most_tests),
      tests_(tests),
      person_(world.shapes[group.shapes[0]].person >= 0) {
  if (person_) find_free_shapes();
  find_directions();
}

void ExitSearch::find_free_shapes() {
  std::vector<char> between(model_.nbody, 0);  // bodies from the group to the root
  for (int i : group_.shapes)
    for (int b = world_.shapes[i].body; b > 0; b = model_.parent[b]) between[b] = 1;
  for (int i = 0; i < (int)world_.shapes.size(); i++)
    for (int j = 0; j < (int)world_.statics.size(); j++) {
      const CollisionShape& M = world_.shapes[i];
      if (!between[M.body] || world_.pairing(M.name, world_.statics[j].name).ignore) continue;
      const Obstacle other = Obstacle::of_static(world_, j);
      const PosedShape& a = world_.place(start_, i);
      Box3 near = a.box();
      near.grow(tune::kFarthestExit);
      if (other.meets(near) && other.clear(displaced(a, {}), tune::kRestingOverlap, tests_))
        free_.push_back({i, other});
    }
}

bool ExitSearch::on_right_side(Vec3 shift) {
  if (obstacle_.object) return true;
  const auto crosses = [&](Vec3 a, Vec3 b) { return obstacle_.crosses(a, b, tests_); };
  const std::vector<Vec3>& x = start_.kin.xpos;
  const std::vector<char>& moves = group_.moves;
  for (int i : group_.shapes) {
    const Vec3 c = world_.place(start_, i).center, j = x[world_.shapes[i].body];
    if (person_ ? crosses(j + shift, c + shift) : !crosses(c, c) && crosses(c, c + shift))
      return false;
  }
  const int root = model_.root[world_.shapes[group_.shapes[0]].body];
  for (int b = 1; b < model_.nbody && person_; b++) {
    if (model_.root[b] != root) continue;
    if (moves[b] && group_.stays[b] && !crosses(x[b], x[b]) && crosses(x[b], x[b] + shift))
      return false;
    const int p = model_.parent[b];
    if (b == root || moves[b] == moves[p]) continue;
    if (crosses(moves[p] ? x[p] + shift : x[p], moves[b] ? x[b] + shift : x[b])) return false;
  }
  return true;
}

bool ExitSearch::enters_another(Vec3 shift) {
  for (const auto& [i, other] : free_)
    if (!other.clear(displaced(world_.place(start_, i), shift), tune::kRestingOverlap, tests_))
      return true;
  return false;
}

bool ExitSearch::fits(Vec3 shift) {
  const std::vector<int>& shapes = group_.shapes;
  for (size_t k = 0; k < shapes.size(); k++) {
    const size_t i = (last_blocked_ + k) % shapes.size();
    if (obstacle_.clear(displaced(world_.place(start_, shapes[i]), shift), tune::kExitClearance,
                        tests_))
      continue;
    last_blocked_ = i;
    return false;
  }
  if (!on_right_side(shift)) return false;
  if (!others_too_ || !enters_another(shift)) return true;
  only_others_block_ = true;
  return false;
}

void ExitSearch::add_direction(Vec3 n) {
  const double length = norm(n);
  if (length < 1e-9 || (int)directions_.size() >= tune::kMostExitDirections) return;
  n = (1 / length) * n;
  for (Vec3 w : directions_)
    if (dot(w, n) > tune::kSameDirection) return;
  directions_.push_back(n);
}

void ExitSearch::find_directions() {
  const Obstacle& o = obstacle_;
  if (o.is(Static::Kind::HalfSpace)) {
    add_direction(o.fixed->n);
    return;
  }
  if (o.is(Static::Kind::Mesh)) {
    const TriangleTree& tree = *o.fixed->tree;
    std::vector<Plane> planes;
    for (int i : group_.shapes) {
      planes.clear();
      tree.planes(world_.place(start_, i), tune::kExitFaces, planes);
      for (const Plane& p : planes) {
        Vec3 v[3];
        tree.triangle(p.triangle, v);
        const Vec3 n = cross(v[1] - v[0], v[2] - v[0]);
        add_direction(n), add_direction(-n);
      }
    }
  } else {
    for (Vec3 n : o.posed().hull->normals) add_direction(o.posed().R * n);
  }
  for (int k = 0; k < 27; k++)
    add_direction({(double)(k % 3 - 1), (double)(k / 3 % 3 - 1), (double)(k / 9 - 1)});
}

// The displacement along w in the stride that ends at `good`, which fits; what is longer than the best
// is not looked at closer.
void ExitSearch::refine(Vec3 w, double bad, double good, Exit& best) {
  if (bad >= best.length) return;
  for (int k = 0; k < tune::kExitBisections; k++) {
    const double t = 0.5 * (good + bad);
    (fits(t * w) ? good : bad) = t;
  }
  if (good < best.length) best = {good * w, good};
}

// All directions a stride farther, and once more, until one fits.
Exit ExitSearch::search() {
  Exit best{{}, tune::kFarthestExit};
  const size_t begun = tests_;
  double before = 0;
  for (double t = tune::kExitStride; before < best.length && tests_ - begun < most_tests_;
       before = t, t += tune::kExitStride)
    for (Vec3 w : directions_)
      if (dot(w, avoid_) <= tune::kOtherDirection && fits(t * w)) refine(w, before, t, best);
  return best;
}

Exit ExitSearch::run() {
  const Exit best = search();
  if (norm2(best.displacement) > 0 || !only_others_block_) return best;
  others_too_ = false;
  return search();
}

}  // namespace hp
