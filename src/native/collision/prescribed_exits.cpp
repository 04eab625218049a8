// Exits of objects from people whose poses are prescribed (stepping/baselines/prescribed_poses.h).
#include "collision/narrow_phase.h"

namespace hp {

namespace {

// An object that would have to leave faster than kThrown times the speed asked to follow two ways out at once,
// the cosine between them being less than 2 / kThrown^2 - 1, does not leave.
constexpr double kThrown = 3;
constexpr double kOpposed = 2 / (kThrown * kThrown) - 1;

}  // namespace

void World::people_put() {
  exits_known_ = false;
  for (auto it = pairs_.begin(); it != pairs_.end();)
    it = shapes[unpacked(it->first).shape].person >= 0 ? pairs_.erase(it) : std::next(it);
}
// All hulls of a person that are neighbours in the skeleton and overlap one thing leave it along one direction:
// that along which the deepest of them is least deep. Hull by hull the ways would work against each other, and
// what is between them would be thrown.
void World::find_exits(const Model& m, Poses& start) {
  exits_known_ = true;
  struct Pair {
    int shape, other, group;
  };
  std::vector<Pair> in;
  for (const BroadPhasePair& e : broad_pairs_) {
    if (e.other_shape < 0 || shapes[e.shape].person < 0 || !takes_part(e)) continue;
    const PosedShape &a = place(start, e.shape), &b = place(start, e.other_shape);
    if (a.box.meets(b.box) && separate(a, b, 0, false).dist < 0) in.push_back({e.shape, e.other_shape, -1});
  }
  auto body = [&](int shape) { return shapes[shape].body; };
  auto neighbours = [&](int a, int b) { return a == b || m.parent[a] == b || m.parent[b] == a; };
  struct Way {
    int thing;
    Vec3 exit;
  };
  std::vector<Way> found;
  squeezed.assign(m.nbody, 0);
  std::vector<Vec3> ways;
  std::vector<size_t> mine;
  for (size_t first = 0; first < in.size(); first++) {
    if (in[first].group >= 0) continue;
    mine.assign(1, first);
    in[first].group = (int)first;
    for (size_t k = 0; k < mine.size(); k++)
      for (size_t i = first + 1; i < in.size(); i++) {
        const Pair& known = in[mine[k]];
        if (in[i].group >= 0 || body(in[i].other) != body(known.other) ||
            !neighbours(body(in[i].shape), body(known.shape)))
          continue;
        in[i].group = (int)first;
        mine.push_back(i);
      }
    ways.clear();
    for (size_t i : mine) {
      const PosedShape &a = place(start, in[i].shape), &b = place(start, in[i].other);
      ways.push_back(separate(a, b).n);
      for (Vec3 n : b.shape->normals) ways.push_back(-(b.R * n));
    }
    for (int k = 0; k < 27; k++) {
      const Vec3 n{(double)(k % 3 - 1), (double)(k / 3 % 3 - 1), (double)(k / 9 - 1)};
      if (k != 13) ways.push_back((1 / norm(n)) * n);
    }
    Vec3 exit;
    double least = -1e300;
    for (Vec3 n : ways) {
      double dist = 0;
      for (size_t i : mine) {
        dist = std::min(dist, separate_along(place(start, in[i].shape), place(start, in[i].other), n).dist);
        if (dist <= least) break;
      }
      if (dist > least) least = dist, exit = n;
    }
    const int thing = body(in[first].other);
    for (const Way& w : found)
      if (w.thing == thing && dot(w.exit, exit) < kOpposed) squeezed[thing] = 1;
    found.push_back({thing, exit});
    for (size_t i : mine) {
      ContactCandidate c;
      c.shape = in[i].shape, c.other_shape = in[i].other;
      pairs_[key(c)] = {settings.clearance, true, exit};
    }
  }
}

}  // namespace hp
