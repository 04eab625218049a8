#include "collision/world.h"

#include <limits>

#include "geometry/separation.h"

namespace hp {

namespace tune = tuning::collision;

// Listed pairs that overlap and are to be parted by depenetration: shapes and statics, people and
// objects. Two objects are not; nor are people whose poses are prescribed. (Two people: people_parting.h.)
std::vector<PairId> World::initial_overlaps(Poses& start) {
  std::vector<PairId> found;
  for (BroadPhasePair& e : broad_phase.pairs()) {
    if (forced && shapes[e.shape].person >= 0) continue;
    bool overlap = false;
    if (e.other_shape >= 0) {
      if (shapes[e.shape].person < 0 || shapes[e.other_shape].person >= 0) continue;
      overlap = separate(place(start, e.shape), place(start, e.other_shape)).dist <
                -tune::kRestingOverlap;
    } else {
      broad_phase.measure_static(start, e, settings.clearance);
      if (statics[e.other_static].kind == Static::Kind::Mesh)
        for (const Plane& p : e.planes) overlap |= p.overlaps;
      else
        overlap = e.dist < -tune::kRestingOverlap;
    }
    if (overlap) found.push_back({e.shape, e.other_static, e.other_shape});
  }
  return found;
}

void World::reset(const Model& m, Poses& start) {
  pair_states.clear();
  depenetration.clear();
  parting.clear();
  std::vector<double> reach(shapes.size(), settings.clearance);
  broad_phase.update(m, start, reach, depenetration.overlaps());
  const std::vector<PairId> found = initial_overlaps(start);
  if (!found.empty()) {
    depenetration.begin(m, start, found, std::numeric_limits<size_t>::max());
    broad_phase.invalidate();  // shapes that are cut off are to be listed too
    broad_phase.update(m, start, reach, depenetration.overlaps());
  }
  if (!forced) parting.begin(m, start, broad_phase.pairs());
  std::vector<ContactCandidate> near;
  narrow_phase.gather(m, start, reach, 1.0, near);
  self_depenetration.reset(m, start);
  for (const ContactCandidate& c : near) remember_pair(c);
  take_tests();  // of no frame
}

// What touches, to within the rounding of files, rests there; what overlaps by more comes out.
void World::remember_pair(const ContactCandidate& c) {
  if (c.dist < -tune::kRestingOverlap && c.other_shape >= 0) {
    const CollisionShape &A = shapes[c.shape], &B = shapes[c.other_shape];
    if (A.person < 0) pair_states[c].kept = -c.dist <= A.slack + B.slack;
  }
  if (c.overlap >= 0 || c.dist < -tune::kRestingOverlap || c.dist >= settings.clearance) return;
  const double own = std::max(c.dist, 0.0);
  PairState& state = pair_states.add(c, {own, false, {}});
  state.clearance = std::min(state.clearance, own);
}

void World::save(std::vector<double>& out) const {
  pair_states.save(out);
  depenetration.save(out);
  parting.save(out);
  broad_phase.save_travel(out);
  self_depenetration.save(out);
  broad_phase.save_pairs(out);
}

const double* World::load(const double* in) {
  in = pair_states.load(in);
  in = depenetration.load(in);
  in = parting.load(in);
  in = broad_phase.load_travel(in);
  in = self_depenetration.load(in);
  return broad_phase.load_pairs(in);
}

void World::adopt(const World& old, const std::vector<int>& shape) {
  std::vector<int> now(old.shapes.size(), -1);  // the other way round
  for (int i = 0; i < (int)shape.size(); i++)
    if (shape[i] >= 0) now[shape[i]] = i;
  auto known = [&](const auto& c) {
    return shape[c.shape] >= 0 && (c.other_shape < 0 || shape[c.other_shape] >= 0);
  };
  auto renamed = [&](auto& c) {
    c.shape = now[c.shape];
    if (c.other_shape >= 0) c.other_shape = now[c.other_shape];
    return c.shape >= 0 && (c.other_static >= 0 || c.other_shape >= 0);
  };
  pair_states.erase_if(known);
  old.pair_states.for_each([&](PairId c, const PairState& state) {
    if (renamed(c)) pair_states[c] = state;
  });
  depenetration.adopt(old.depenetration, renamed, known);
  parting.adopt(old.parting, now);
  broad_phase.invalidate();
}

}  // namespace hp
