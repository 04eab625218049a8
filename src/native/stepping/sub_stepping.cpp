// A step that cannot be made whole: how much of it each island makes, and the rest in pieces.
#include "stepping/stepper.h"

namespace hp {

namespace {

// Who could not make the whole step tries again: so often; a step of which less than this share is
// possible is not begun but tried this much shorter; and what is left counts above this share.
constexpr int kRetries = 12;
constexpr double kWorthwhile = 0.25, kShorter = 0.25, kNothing = 1e-6;
constexpr int kBisections = 6;
// Who moves farther than planes were asked for keeps this much of what lies beyond [m].
constexpr double kBeyond = 1e-4;

}  // namespace

// Which share of the step of length h each tree can make, by island; empty if all can make all of
// it. Leaves the end pose at those shares.
std::vector<double> Stepper::shares(double h) {
  std::vector<double> good(model.nbody, 0), bad(model.nbody, 1), at(model.nbody, 1);
  auto check = [&]() {
    std::vector<char> ok(model.nbody, 1);
    for (ContactCandidate& c : candidates_) c.share = at[world.shapes[c.shape].body];
    for (size_t i = 0; i < candidates_.size(); i++)
      if (excess(i, h) + candidates_[i].target < candidates_[i].hard) ok[island(candidates_[i])] = 0;
    // Planes hold for what was asked only.
    ways(world.shapes, start_, end_, world.active, way_);
    for (size_t i = 0; i < reach_.size(); i++)
      if (world.active[world.shapes[i].body] && way_[i] + kBeyond > reach_[i])
        ok[island_[tree((int)i)]] = 0;
    return ok;
  };
  find_islands();
  std::vector<char> ok = check(), hurt(model.nbody, 0);
  bool any = false;
  for (int b = 1; b < model.nbody; b++)
    if (world.active[b] && !ok[island_[model.root[b]]]) hurt[b] = 1, any = true;
  if (!any) return {};
  auto move = [&]() {
    for (int i = 0; i < model.nv; i++) moved_[i] = v_[i] * at[model.dof_body[i]];
    pose_at(moved_, h, end_, q_end_);
  };
  for (int it = 0; it < kBisections; it++) {
    for (int b = 1; b < model.nbody; b++)
      if (hurt[b]) at[b] = 0.5 * (good[b] + bad[b]);
    move();
    ok = check();
    for (int b = 1; b < model.nbody; b++)
      if (hurt[b]) (ok[island_[model.root[b]]] ? good[b] : bad[b]) = at[b];
  }
  for (int b = 1; b < model.nbody; b++)
    if (hurt[b]) at[b] = good[b];
  return at;
}

// The step is made: by the trees' shares of it; who has a negative one has not begun.
void Stepper::commit(double h, const std::vector<double>& share) {
  if (!share.empty()) {
    for (int i = 0; i < model.nv; i++)
      moved_[i] = v_[i] * std::max(0.0, share[model.dof_body[i]]);
    pose_at(moved_, h, end_, q_end_);
  }
  remember(share);
  ways(world.shapes, start_, end_, world.active, way_);
  world.inner_ways(model, start_, end_, sweep_.inner);
  world.travel(way_, sweep_.inner);
  world.come_out(share);
  std::swap(start_, end_);
  qpos_ = q_end_;
  if (record_) record_->insert(record_->end(), qpos_.begin(), qpos_.end());
  for (int i = 0; i < model.nv; i++)
    if (share.empty() || share[model.dof_body[i]] >= 0) v_free_[i] = v_[i];
}

// What was shortened tries to make the rest of its step, in pieces short enough, while all others
// stand where they arrived. Returns the time that is lost.
double Stepper::catch_up(double h, double left, bool begun) {
  double length = begun ? left : kShorter * left;
  for (int retry = 1; left > kNothing * h; retry++) {
    if (retry > kRetries) return left;
    if (begun) {
      // The velocities are kept: what contacts gave is in them.
      warm_.clear();
      pulled_ = 0;
    }
    if (begun || retry == 1) {
      end_ = start_;
      start_.kin.update_dofs(model, qpos_.data(), world.active.data());
      inertia_ready_ = false;
    }
    length = std::min(length, left);
    attempt(length);
    std::vector<double> share;
    if (!good_) share = shares(length);
    double least = 1;
    for (int b = 1; b < model.nbody && !share.empty(); b++)
      if (world.active[b]) least = std::min(least, share[b]);
    if (least < kWorthwhile && retry < kRetries) {
      length *= kShorter;
      continue;
    }
    if (least < 1) share.assign(model.nbody, least);
    commit(length, share);
    begun = true;
    left -= least * length;
    if (least == 1) length *= 2;
  }
  return 0;
}

// Those who made only a share of the step go on one island after the other.
double Stepper::retry(double h, std::vector<double> share) {
  const std::vector<char> all = world.active, stood = world.standing;
  const std::vector<int> islands = island_;
  const double pulled = pulled_;
  std::vector<double> left(model.nbody, 0);
  for (int b = 1; b < model.nbody; b++) {
    if (!all[b] || share[b] == 1) continue;
    if (share[b] < kWorthwhile) share[b] = -1;
    left[b] = h * (1 - std::max(0.0, share[b]));
    disturbed_[model.root[b]] = 1;
  }
  commit(h, share);
  double lost = 0;
  const std::vector<CachedContact> warm = warm_;
  for (int first = 1; first < model.nbody; first++) {
    if (left[first] == 0 || model.root[first] != first) continue;
    const int which = islands[first];
    const double rest = left[first];
    for (int b = 1; b < model.nbody; b++) {
      world.active[b] = all[b] && islands[model.root[b]] == which;
      world.standing[b] = stood[b] || (all[b] && !world.active[b]);
      if (world.active[b]) left[b] = 0;
    }
    pulled_ = pulled;
    warm_ = warm;
    const double late = catch_up(h, rest, share[first] >= 0);
    for (int b = 1; b < model.nbody; b++)
      if (world.active[b]) behind_[b] = late;
    lost = std::max(lost, late);
  }
  world.active = all;
  world.standing = stood;
  return lost;
}

}  // namespace hp
