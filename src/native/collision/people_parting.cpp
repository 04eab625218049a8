#include "collision/people_parting.h"

#include <algorithm>
#include <cmath>

#include "geometry/separation.h"
#include "tuning.h"

namespace hp {

namespace tune = tuning::collision;

bool PeopleParting::between(int shape, int other_shape) const {
  const int a = world_.shapes[shape].person, b = world_.shapes[other_shape].person;
  for (const Parting& p : all_)
    if ((p.moved == a && p.other == b) || (p.moved == b && p.other == a)) return true;
  return false;
}

bool PeopleParting::concerns(int person) const {
  return std::any_of(all_.begin(), all_.end(),
                     [&](const Parting& p) { return p.moved == person || p.other == person; });
}

void PeopleParting::begin(const Model& m, Poses& start, const std::vector<BroadPhasePair>& pairs) {
  for (const BroadPhasePair& e : pairs) {
    if (e.other_shape < 0 || e.own || between(e.shape, e.other_shape)) continue;
    const CollisionShape &a = world_.shapes[e.shape], &b = world_.shapes[e.other_shape];
    if (a.person < 0 || b.person < 0 || a.person == b.person) continue;
    if (separate(world_.place(start, e.shape), world_.place(start, e.other_shape)).dist >=
        -tune::kRestingOverlap)
      continue;
    const bool lighter = m.carried[m.root[a.body]] < m.carried[m.root[b.body]];
    Parting p;
    p.moved = lighter ? a.person : b.person, p.other = lighter ? b.person : a.person;
    p.shape = lighter ? e.shape : e.other_shape, p.other_shape = lighter ? e.other_shape : e.shape;
    find_way(start, p);
    all_.push_back(p);
  }
}

// Is a shape that is shifted nearer to another one than the clearance? `depth`: by how much.
bool PeopleParting::blocks(Poses& start, int shape, int other_shape, Vec3 shift,
                           double& depth) const {
  const PosedShape &a = world_.place(start, shape), &b = world_.place(start, other_shape);
  Box3 box = a.box();
  box.lo += shift, box.hi += shift;
  box.grow(world_.settings.clearance);
  if (!box.meets(b.box())) return false;
  const double clearance = world_.settings.clearance;
  depth = clearance - separate(displaced(a, shift), b, clearance).dist;
  return depth > 0;
}

// Are the two clear where the first is shifted? Else p names a pair that is not, and `depth` by how much.
bool PeopleParting::clear(Poses& start, Parting& p, Vec3 shift, double& depth) const {
  if (blocks(start, p.shape, p.other_shape, shift, depth)) return false;
  const int n = (int)world_.shapes.size();
  for (int i = 0; i < n; i++)
    for (int j = 0; j < n && world_.shapes[i].person == p.moved; j++) {
      if (world_.shapes[j].person != p.other || !blocks(start, i, j, shift, depth)) continue;
      p.shape = i, p.other_shape = j;
      return false;
    }
  return true;
}

// A shift by less than the depth of a pair does not clear it.
void PeopleParting::find_way(Poses& start, Parting& p) const {
  p.left = tune::kFarthestParting;
  const Parting first = p;
  for (int k = 0; k < tune::kPartingWays; k++) {
    const double angle = 2 * M_PI * k / tune::kPartingWays;
    Parting tried = first;
    tried.way = {elementary::cos(angle), elementary::sin(angle), 0};
    double depth = 0;
    tried.left = 0;
    while (tried.left < p.left && !clear(start, tried, tried.left * tried.way, depth))
      tried.left += std::max(depth, tune::kPartingStride);
    if (tried.left < p.left || norm2(p.way) == 0) p = tried;
  }
  p.shape = first.shape, p.other_shape = first.other_shape;
}

void PeopleParting::update(Poses& start) {
  if (all_.empty() || stamp_ == start.stamp) return;
  stamp_ = start.stamp;
  double depth = 0;
  all_.erase(std::remove_if(all_.begin(), all_.end(),
                            [&](Parting& p) { return clear(start, p, {}, depth); }),
             all_.end());
}

void PeopleParting::advance(size_t k, double moved, double asked) {
  Parting& p = all_[k];
  p.left = std::max(0.0, p.left - moved);
  p.blocked = moved < tune::kPartingBlocked * asked ? p.blocked + 1 : 0;
  if (p.blocked < tune::kStuckPatience) return;
  std::swap(p.moved, p.other);
  std::swap(p.shape, p.other_shape);
  p.way = -p.way;
  p.blocked = 0;
}

void PeopleParting::save(std::vector<double>& out) const {
  out.push_back((double)all_.size());
  for (const Parting& p : all_)
    out.insert(out.end(), {(double)p.moved, (double)p.other, p.way.x, p.way.y, p.way.z, p.left,
                           (double)p.blocked, (double)p.shape, (double)p.other_shape});
}

const double* PeopleParting::load(const double* in) {
  clear();
  for (int n = (int)*in++; n > 0; n--, in += 9)
    all_.push_back(
        {(int)in[0], (int)in[1], load3(in + 2), in[5], (int)in[6], (int)in[7], (int)in[8]});
  return in;
}

void PeopleParting::adopt(const PeopleParting& old, const std::vector<int>& shape_now) {
  clear();
  for (Parting p : old.all_) {
    p.shape = shape_now[p.shape], p.other_shape = shape_now[p.other_shape];
    if (p.shape >= 0 && p.other_shape >= 0) all_.push_back(p);
  }
}

}  // namespace hp
