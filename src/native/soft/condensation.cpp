#include "soft/condensation.h"

#include <algorithm>
#include <cmath>

#include "soft/sample_lanes.h"
#include "tuning.h"

namespace hp {

namespace tune = tuning::soft;

using N = NearSamples;

// Marks those of no patch yet that face like the seed; returns the largest impulse of what is left.
HP_CLONES double mark_patch(Vec3 seed, int patch, std::vector<PressedBlock>& blocks) {
  const Lanes zero = {}, least = zero + tune::kSamePatch;
  double most[PressedBlock::kSize] = {};
  for (PressedBlock& b : blocks)
    for (int k = 0; k < PressedBlock::kSize; k += kLanes) {
      Lanes& own = lanes(b.patch + k);
      const Lanes like =
          lanes(b.n[0] + k) * seed.x + lanes(b.n[1] + k) * seed.y + lanes(b.n[2] + k) * seed.z;
      const Lanes now = like > least ? zero + (double)patch : own;
      own = own < zero ? now : own;
      const Lanes left = own < zero ? lanes(b.impulse + k) : zero;
      Lanes& max = lanes(most + k);
      max = left > max ? left : max;
    }
  return std::max(std::max(most[0], most[1]), std::max(most[2], most[3]));
}

HP_CLONES void add_forces(double patch, const std::vector<PressedBlock>& blocks, FourSums3& force) {
  const Lanes zero = {};
  for (const PressedBlock& b : blocks)
    for (int k = 0; k < PressedBlock::kSize; k += kLanes) {
      const Lanes q = lanes(b.patch + k) == zero + patch ? lanes(b.impulse + k) : zero;
      for (int i = 0; i < 3; i++) force.of[i].add(k, q * lanes(b.n[i] + k));
    }
}

// Sums along the patch's normal n, of places too.
struct PatchSums {
  FourSums impulse, yield;
  FourSums3 loaded, yielding;
};
HP_CLONES void add_places(double patch, Vec3 n, const std::vector<PressedBlock>& blocks,
                          PatchSums& sums) {
  const Lanes zero = {};
  for (const PressedBlock& b : blocks)
    for (int k = 0; k < PressedBlock::kSize; k += kLanes) {
      const Lanes along =
          lanes(b.n[0] + k) * n.x + lanes(b.n[1] + k) * n.y + lanes(b.n[2] + k) * n.z;
      const auto own = lanes(b.patch + k) == zero + patch;
      const Lanes q = own ? lanes(b.impulse + k) * along : zero;
      const Lanes s = own ? lanes(b.yield + k) : zero;
      sums.impulse.add(k, q), sums.yield.add(k, s);
      for (int i = 0; i < 3; i++) {
        sums.loaded.of[i].add(k, q * lanes(b.x[i] + k));
        sums.yielding.of[i].add(k, s * lanes(b.x[i] + k));
      }
    }
}

// Second moments of the yields about a place, along two directions across n.
struct PatchMoments {
  FourSums tt, tb, bb;
};
HP_CLONES void add_moments(double patch, Vec3 about, Vec3 t, Vec3 b,
                           const std::vector<PressedBlock>& blocks, PatchMoments& sums) {
  const Lanes zero = {};
  for (const PressedBlock& block : blocks)
    for (int k = 0; k < PressedBlock::kSize; k += kLanes) {
      const Lanes s = lanes(block.patch + k) == zero + patch ? lanes(block.yield + k) : zero;
      const Lanes x = lanes(block.x[0] + k) - about.x, y = lanes(block.x[1] + k) - about.y,
                  z = lanes(block.x[2] + k) - about.z;
      const Lanes u = x * t.x + y * t.y + z * t.z, v = x * b.x + y * b.y + z * b.z;
      sums.tt.add(k, s * u * u), sums.tb.add(k, s * u * v), sums.bb.add(k, s * v * v);
    }
}

namespace {

struct Seed {
  Vec3 n;
  int member = 0;
};

// The sample of no patch yet with that impulse.
Seed seed_of(double impulse, const std::vector<PressedBlock>& blocks) {
  for (const PressedBlock& b : blocks)
    for (int k = 0; k < PressedBlock::kSize; k++)
      if (b.patch[k] < 0 && b.impulse[k] == impulse) return {b.normal(k), b.member[k]};
  return {};
}

// Those of no patch yet belong to the seed that they face most like.
void take_to_likeliest(const Seed* seeds, int n, std::vector<PressedBlock>& blocks) {
  for (PressedBlock& b : blocks)
    for (int i = 0; i < PressedBlock::kSize; i++) {
      if (b.patch[i] >= 0 || !(b.impulse[i] > 0)) continue;
      int like = 0;
      for (int k = 1; k < n; k++)
        if (dot(b.normal(i), seeds[k].n) > dot(b.normal(i), seeds[like].n)) like = k;
      b.patch[i] = like;
    }
}

// Which patch each sample belongs to: seeds are the samples with the largest impulses that no seed before
// them faces like. Returns how many there are.
int find_patches(PressedSamples& all, Seed (&seeds)[tune::kMostPatches]) {
  std::vector<PressedBlock>& blocks = all.blocks();
  double most = 0;
  for (PressedBlock& b : blocks)
    for (int k = 0; k < PressedBlock::kSize; k++) {
      b.patch[k] = -1;
      most = std::max(most, b.impulse[k]);
    }
  int n = 0;
  for (; n < tune::kMostPatches && most > 0; n++) {
    seeds[n] = seed_of(most, blocks);
    most = mark_patch(seeds[n].n, n, blocks);
  }
  if (most > 0) take_to_likeliest(seeds, n, blocks);
  return n;
}

// Sums over the samples of one patch.
struct Patch {
  Vec3 n;                         // of the whole impulse
  double impulse = 0, yield = 0;  // Q, S
  Vec3 centre, loaded;            // x_S, x_Q
  Vec3 axis[2];
  double spread[2] = {0, 0};  // s1, s2
};

// Principal axes and standard deviations in the plane across p.n.
void find_axes(const PressedSamples& all, int index, Patch& p) {
  Vec3 t, b;
  tangents(p.n, t, b);
  PatchMoments sums;
  add_moments(index, p.centre, t, b, all.blocks(), sums);
  const double tt = sums.tt.total() / p.yield, tb = sums.tb.total() / p.yield,
               bb = sums.bb.total() / p.yield;
  const double half = 0.5 * (tt - bb), root = std::sqrt(half * half + tb * tb);
  const double mean = 0.5 * (tt + bb);
  // The eigenvector of the larger value, from whichever of its two forms is longer.
  double c = half + root, s = tb;
  if (half < 0) c = tb, s = root - half;
  const double length = std::sqrt(c * c + s * s);
  if (length > 0)
    c /= length, s /= length;
  else
    c = 1, s = 0;
  p.axis[0] = c * t + s * b;
  p.axis[1] = c * b - s * t;
  p.spread[0] = std::sqrt(std::max(0.0, mean + root));
  p.spread[1] = std::sqrt(std::max(0.0, mean - root));
}

bool find_patch(const PressedSamples& all, int index, Patch& p) {
  FourSums3 force;
  add_forces(index, all.blocks(), force);
  const double length = norm(force.total());
  if (!(length > 0)) return false;
  p.n = (1 / length) * force.total();
  p.impulse = length;
  PatchSums sums;
  add_places(index, p.n, all.blocks(), sums);
  const double along = sums.impulse.total();
  p.yield = sums.yield.total();
  if (!(along > 0) || !(p.yield > 0)) return false;
  p.loaded = (1 / along) * sums.loaded.total();
  p.centre = (1 / p.yield) * sums.yielding.total();
  find_axes(all, index, p);
  return true;
}

void add_points(const Patch& p, int index, int member, double least_turn,
                std::vector<PatchPoint>& out) {
  const double least = std::max(tune::kPointSpread * tune::kPointSpread, least_turn / p.yield);
  int lines = 0;
  while (lines < 2 && p.spread[lines] * p.spread[lines] > least) lines++;
  const int count = 1 << lines;
  double tilt[2] = {0, 0};
  Vec3 centre = p.loaded;
  for (int k = 0; k < lines; k++) tilt[k] = dot(p.loaded - p.centre, p.axis[k]) / p.spread[k];
  if (std::fabs(tilt[0]) + std::fabs(tilt[1]) <= tune::kMostTilt) {
    for (int k = 0; k < lines; k++) centre -= tilt[k] * p.spread[k] * p.axis[k];
  } else {
    tilt[0] = tilt[1] = 0;
  }
  for (int j = 0; j < count; j++) {
    PatchPoint point;
    point.x = centre, point.n = p.n, point.patch = index, point.member = member;
    double share = 1;
    for (int k = 0; k < lines; k++) {
      const double sign = j >> k & 1 ? -1 : 1;
      point.x += sign * p.spread[k] * p.axis[k];
      share += sign * tilt[k];
    }
    point.impulse = p.impulse / count * share;
    point.yield = p.yield / count;
    out.push_back(point);
  }
}

}  // namespace

void list_pressed(const SoftPair& pair, int member, Rule rule, double h, Vec3 way,
                  PressedSamples& out) {
  const N& near = pair.near;
  const double *pressure = near[N::Pressure], *slope = near[N::Slope], *area = near[N::Area];
  const double *own = near[N::Own], share = moving_share(rule) * h;
  for (int i = 0; i < near.size(); i++) {
    if (!(pressure[i] > 0)) continue;
    int k;
    PressedBlock& p = out.add(k);
    Vec3 x = near.vector(N::Hard, i);
    if (own[i] > 0) x += own[i] * near.vector(N::Normal, i);
    if (rule == Rule::Mean) x = 0.5 * (x + near.vector(N::First, i) + way);
    const Vec3 n = near.vector(N::Away, i);
    for (int c = 0; c < 3; c++) p.x[c][k] = x[c], p.n[c][k] = n[c];
    p.load[k] = area[i] * pressure[i];
    p.impulse[k] = share * p.load[k];
    // The depth at the end is that at the start less h w.
    p.yield[k] = share * h * area[i] * slope[i];
    p.sample[k] = near.sample[i], p.member[k] = member;
  }
}

// Sums over samples of the impulse, its moment, its size, and that times its distance.
struct ImpulseSums {
  FourSums3 force, moment;
  FourSums size, lever;
};

HP_CLONES void add_impulses(Rule rule, double h, Vec3 way, Vec3 about, const NearSamples& near,
                            ImpulseSums& sums) {
  const double share = moving_share(rule) * h;
  for (int i = 0; i < near.size(); i += kLanes) {
    const ConstSampleLanes at{near, i};
    const int part = i % PressedBlock::kSize;
    const Lanes q = share * (at(N::Area) * at(N::Pressure));
    Lanes r[3], f[3];
    for (int k = 0; k < 3; k++) {
      const Lanes x = at(N::Hard, k) + at(N::Own) * at(N::Normal, k);
      r[k] = (rule == Rule::End ? x : 0.5 * (x + at(N::First, k) + way[k])) - about[k];
      f[k] = q * at(N::Away, k);
    }
    for (int k = 0; k < 3; k++) {
      const int l = (k + 1) % 3, m = (k + 2) % 3;
      sums.force.of[k].add(part, f[k]);
      sums.moment.of[k].add(part, r[l] * f[m] - r[m] * f[l]);
    }
    sums.size.add(part, q);
    sums.lever.add(part, q * square_root(r[0] * r[0] + r[1] * r[1] + r[2] * r[2]));
  }
}

PairImpulse total_impulse(const std::vector<const SoftPair*>& pairs, Rule rule, double h, Vec3 way,
                          Vec3 about) {
  ImpulseSums sums;
  for (const SoftPair* pair : pairs) add_impulses(rule, h, way, about, pair->near, sums);
  PairImpulse all{sums.force.total(), sums.moment.total(), sums.size.total(), sums.lever.total()};
  if (all.size > 0) all.lever /= all.size;
  return all;
}

void condense(PressedSamples& pressed, double least_turn, std::vector<PatchPoint>& out) {
  Seed seeds[tune::kMostPatches];
  const int n = find_patches(pressed, seeds);
  for (int k = 0; k < n; k++) {
    Patch p;
    if (find_patch(pressed, k, p)) add_points(p, k, seeds[k].member, least_turn, out);
  }
}

}  // namespace hp
