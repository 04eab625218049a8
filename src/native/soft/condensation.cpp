#include "soft/condensation.h"

#include <algorithm>
#include <cmath>

#include "tuning.h"

namespace hp {

namespace tune = tuning::soft;

namespace {

double impulse_of(const NearSample& s, Rule rule, double h) {
  return moving_share(rule) * h * s.area * s.pressure;
}

// -dq/dw: the depth at the end is that at the start less h w.
double yield_of(const NearSample& s, Rule rule, double h) {
  return moving_share(rule) * h * h * s.area * s.slope;
}

// Which patch each sample belongs to: seeds are the samples with the largest impulses that no seed before
// them faces like.
int find_patches(const SoftPair& pair, std::vector<int>& patch) {
  const std::vector<NearSample>& near = pair.near;
  patch.assign(near.size(), -1);
  Vec3 seed[tune::kMostPatches];
  int n = 0;
  for (; n < tune::kMostPatches; n++) {
    int best = -1;
    for (size_t i = 0; i < near.size(); i++)
      if (near[i].pressure > 0 && patch[i] < 0 &&
          (best < 0 || near[i].area * near[i].pressure > near[best].area * near[best].pressure))
        best = (int)i;
    if (best < 0) return n;
    seed[n] = near[best].n;
    for (size_t i = 0; i < near.size(); i++)
      if (near[i].pressure > 0 && patch[i] < 0 && dot(near[i].n, seed[n]) > tune::kSamePatch)
        patch[i] = n;
  }
  for (size_t i = 0; i < near.size(); i++) {
    if (near[i].pressure <= 0 || patch[i] >= 0) continue;
    patch[i] = 0;
    for (int k = 1; k < n; k++)
      if (dot(near[i].n, seed[k]) > dot(near[i].n, seed[patch[i]])) patch[i] = k;
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
void find_axes(const SoftPair& pair, const std::vector<int>& patch, int index, Rule rule, double h,
               Patch& p) {
  Vec3 t, b;
  tangents(p.n, t, b);
  double tt = 0, tb = 0, bb = 0;
  for (size_t i = 0; i < pair.near.size(); i++) {
    if (patch[i] != index) continue;
    const double share = yield_of(pair.near[i], rule, h) / p.yield;
    const Vec3 r = pair.near[i].y - p.centre;
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

bool find_patch(const SoftPair& pair, const std::vector<int>& patch, int index, Rule rule, double h,
                Patch& p) {
  Vec3 force;
  for (size_t i = 0; i < pair.near.size(); i++)
    if (patch[i] == index) force += impulse_of(pair.near[i], rule, h) * pair.near[i].n;
  const double length = norm(force);
  if (!(length > 0)) return false;
  p.n = (1 / length) * force;
  p.impulse = length;
  double along = 0;
  for (size_t i = 0; i < pair.near.size(); i++) {
    if (patch[i] != index) continue;
    const NearSample& s = pair.near[i];
    const double q = impulse_of(s, rule, h) * dot(s.n, p.n), yield = yield_of(s, rule, h);
    along += q, p.yield += yield;
    p.loaded += q * s.y, p.centre += yield * s.y;
  }
  if (!(along > 0) || !(p.yield > 0)) return false;
  p.loaded = (1 / along) * p.loaded;
  p.centre = (1 / p.yield) * p.centre;
  find_axes(pair, patch, index, rule, h, p);
  return true;
}

void add_points(const Patch& p, int index, double least_turn, std::vector<PatchPoint>& out) {
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
    point.x = centre, point.n = p.n, point.patch = index;
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

PairImpulse total_impulse(const SoftPair& pair, Rule rule, double h, Vec3 about) {
  PairImpulse sum;
  for (const NearSample& s : pair.near) {
    if (s.pressure <= 0) continue;
    const double q = impulse_of(s, rule, h);
    sum.force += q * s.n;
    sum.moment += q * cross(s.y - about, s.n);
    sum.size += q;
    sum.lever += q * norm(s.y - about);
  }
  if (sum.size > 0) sum.lever /= sum.size;
  return sum;
}

void condense(const SoftPair& pair, Rule rule, double h, double least_turn,
              std::vector<PatchPoint>& out, std::vector<int>& patch) {
  const int n = find_patches(pair, patch);
  for (int k = 0; k < n; k++) {
    Patch p;
    if (find_patch(pair, patch, k, rule, h, p)) add_points(p, k, least_turn, out);
  }
}

}  // namespace hp
