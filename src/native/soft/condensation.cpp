#include "soft/condensation.h"

#include <algorithm>
#include <cmath>

#include "tuning.h"

namespace hp {

namespace tune = tuning::soft;

namespace {

// Which patch each sample belongs to: seeds are the samples with the largest impulses that no seed before
// them faces like. Returns how many there are.
int find_patches(std::vector<PressedSample>& all, int seeds[tune::kMostPatches]) {
  int n = 0;
  for (PressedSample& p : all) p.patch = -1;
  for (; n < tune::kMostPatches; n++) {
    int best = -1;
    for (size_t i = 0; i < all.size(); i++)
      if (all[i].patch < 0 && (best < 0 || all[i].impulse > all[best].impulse)) best = (int)i;
    if (best < 0) return n;
    seeds[n] = best;
    const Vec3 seed = all[best].n;
    for (PressedSample& p : all)
      if (p.patch < 0 && dot(p.n, seed) > tune::kSamePatch) p.patch = n;
  }
  const auto likeness = [&](const PressedSample& p, int k) { return dot(p.n, all[seeds[k]].n); };
  for (PressedSample& p : all) {
    if (p.patch >= 0) continue;
    int like = 0;
    for (int k = 1; k < n; k++)
      if (likeness(p, k) > likeness(p, like)) like = k;
    p.patch = like;
  }
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
void find_axes(const std::vector<PressedSample>& all, int index, Patch& p) {
  Vec3 t, b;
  tangents(p.n, t, b);
  double tt = 0, tb = 0, bb = 0;
  for (const PressedSample& s : all) {
    if (s.patch != index) continue;
    const double share = s.yield / p.yield;
    const Vec3 r = s.x - p.centre;
    const double u = dot(r, t), v = dot(r, b);
    tt += share * u * u, tb += share * u * v, bb += share * v * v;
  }
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

bool find_patch(const std::vector<PressedSample>& all, int index, Patch& p) {
  Vec3 force;
  for (const PressedSample& s : all)
    if (s.patch == index) force += s.impulse * s.n;
  const double length = norm(force);
  if (!(length > 0)) return false;
  p.n = (1 / length) * force;
  p.impulse = length;
  double along = 0;
  for (const PressedSample& s : all) {
    if (s.patch != index) continue;
    const double q = s.impulse * dot(s.n, p.n);
    along += q, p.yield += s.yield;
    p.loaded += q * s.x, p.centre += s.yield * s.x;
  }
  if (!(along > 0) || !(p.yield > 0)) return false;
  p.loaded = (1 / along) * p.loaded;
  p.centre = (1 / p.yield) * p.centre;
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
                  std::vector<PressedSample>& out) {
  using N = NearSamples;
  const N& near = pair.near;
  const double *pressure = near[N::Pressure], *slope = near[N::Slope], *area = near[N::Area];
  const double *own = near[N::Own], share = moving_share(rule) * h;
  out.reserve(out.size() + near.size());
  for (int i = 0; i < near.size(); i++) {
    if (!(pressure[i] > 0)) continue;
    PressedSample p;
    p.x = near.vector(N::Hard, i);
    if (own[i] > 0) p.x += own[i] * near.vector(N::Normal, i);
    if (rule == Rule::Mean) p.x = 0.5 * (p.x + near.vector(N::First, i) + way);
    p.n = near.vector(N::Away, i);
    p.load = area[i] * pressure[i];
    p.impulse = share * p.load;
    p.yield = share * h * area[i] * slope[i];  // the depth at the end is that at the start less h w
    p.sample = near.sample[i], p.member = member;
    out.push_back(p);
  }
}

PairImpulse total_impulse(const std::vector<PressedSample>& pressed, Vec3 about) {
  PairImpulse sum;
  for (const PressedSample& p : pressed) {
    const Vec3 r = p.x - about;
    sum.force += p.impulse * p.n;
    sum.moment += p.impulse * cross(r, p.n);
    sum.size += p.impulse;
    sum.lever += p.impulse * norm(r);
  }
  if (sum.size > 0) sum.lever /= sum.size;
  return sum;
}

void condense(std::vector<PressedSample>& pressed, double least_turn,
              std::vector<PatchPoint>& out) {
  int seeds[tune::kMostPatches];
  const int n = find_patches(pressed, seeds);
  for (int k = 0; k < n; k++) {
    Patch p;
    if (find_patch(pressed, k, p)) add_points(p, k, pressed[seeds[k]].member, least_turn, out);
  }
}

}  // namespace hp
