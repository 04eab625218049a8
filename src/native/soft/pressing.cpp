#include "soft/pressing.h"

#include <algorithm>
#include <cmath>
#include <numeric>

#include "math/lanes.h"
#include "soft/pressures.h"
#include "tuning.h"

namespace hp {

namespace tune = tuning::soft;

FrameDistance frame_of(const CollisionWorld& world, const SoftWorld& soft, Poses& pose,
                       const SoftPair& pair) {
  return pair.other_static >= 0 ? FrameDistance::of_static(world, soft, pair.other_static)
                                : FrameDistance::of_shape(world, soft, pose, pair.other_shape);
}

FoamFrame foam_frame(const CollisionWorld& world, const Poses& pose, const SoftPair& pair) {
  if (pair.other_static >= 0) return {pair.other_static, false, {}, {}};
  const int b = world.shapes[pair.other_shape].body;
  return {-pair.other_shape - 1, true, pose.kin.xpos[b], pose.kin.xmat[b]};
}

void SeenSamples::resize(int n) {
  if ((int)triangle_.size() == n) return;
  triangle_.assign(n, -1);
  until_.assign((n + kBlock - 1) / kBlock * kBlock, kNever);
  std::fill_n(until_.begin(), n, -kNever);
}

HP_CLONES double SeenSamples::find(double travelled, std::vector<int>& out) const {
  double least = kNever;
  for (size_t first = 0; first < until_.size(); first += kBlock) {
    const double* block = until_.data() + first;
    Lanes low = lanes(block);
    for (int k = kLanes; k < kBlock; k += kLanes)
      low = lanes(block + k) < low ? lanes(block + k) : low;
    if (least_of(low) > travelled) {
      least = std::min(least, least_of(low));
      continue;
    }
    for (int k = 0; k < kBlock; k++)
      if (block[k] <= travelled)
        out.push_back((int)first + k);
      else
        least = std::min(least, block[k]);
  }
  return least;
}

namespace {

using N = NearSamples;

// Where a sample's hard point is, and the nearest point of the frame if that is within reach.
struct Measured {
  Vec3 hard;
  bool found = false;
  FramePoint frame;
};

Measured measure(const SamplePoses& poses, const FrameDistance& frame, double within, int sample,
                 int triangle) {
  Measured m;
  m.frame.triangle = triangle;
  m.hard = poses.position(sample);
  m.found = frame.nearest(m.hard, within, triangle, m.frame);
  return m;
}

void keep(const Measured& m, int i, N& near) {
  near.measured[i] = m.found, near.celled[i] = false;
  near.triangle[i] = m.frame.triangle;
  near.set(N::Hard, i, m.hard);
  if (!m.found) return;
  near.set(N::Away, i, m.frame.n), near.set(N::At, i, m.frame.at);
  near[N::Distance][i] = m.frame.distance, near[N::LayerThickness][i] = m.frame.thickness;
}

// The same of one whose hard point is known.
void measure_at(const FrameDistance& frame, double within, int i, N& near) {
  Measured m;
  m.frame.triangle = near.triangle[i];
  m.hard = near.vector(N::Hard, i);
  m.found = frame.nearest(m.hard, within, near.triangle[i], m.frame);
  keep(m, i, near);
}

// The samples of a pair at the start of a step.
struct NearSearch {
  const SurfaceSamples& samples;
  const SoftLayer& own;
  FrameDistance frame;
  SamplePoses poses;
  double reach, travelled;
  SoftPair& pair;
  std::vector<int> places = {}, more = {};

  // So far beyond the thickness a sample may be pressed: its depths spread, or the thickness differs.
  double slack(int sample) const {
    const bool even = !poses.turns() && frame.layer().corners.empty();
    return even ? samples.half_width[sample] : samples.pitch;
  }
  // What is out of reach is noted, and false.
  bool note(int sample, int triangle, double off) {
    off -= slack(sample);
    if (off <= reach) return true;
    pair.quiet = std::min(pair.quiet, pair.seen.put(sample, triangle, off, travelled));
    return false;
  }
  bool reaches(int sample, int triangle, Measured& m) {
    const double room = reach + slack(sample) + tune::kSeenMargin;
    m = measure(poses, frame, pair.thickness + room, sample, triangle);
    return note(sample, m.frame.triangle, m.found ? m.frame.distance - pair.thickness : room);
  }

  // Have all that were near been measured here, and are near?
  bool all_stay() const {
    const N& near = pair.near;
    const double *distance = near[N::Distance], *slack = near[N::Slack];
    const double most = pair.thickness + reach;
    bool stay = true;
    for (int i = 0; i < near.size(); i++)
      stay &= near.measured[i] && distance[i] - slack[i] <= most;
    return stay;
  }

  // Those that were near.
  void look_again(bool kept) {
    N& near = pair.near;
    if (kept && all_stay()) return;
    Measured m;
    places.clear();
    for (int i = 0; i < near.size(); i++) {
      const int s = near.sample[i];
      if (kept && near.measured[i]) {
        if (note(s, near.triangle[i], near[N::Distance][i] - pair.thickness)) places.push_back(i);
      } else if (reaches(s, near.triangle[i], m)) {
        keep(m, i, near);
        places.push_back(i);
      }
    }
    if ((int)places.size() < near.size()) near.keep(places);
  }

  // The others: they follow at first, then all are put in order.
  void find_more() {
    N& near = pair.near;
    const int known = near.size();
    more.clear();
    pair.quiet = pair.seen.find(travelled + reach, more);
    for (const int s : more) look_at(s);
    if (near.size() == known) return;
    places.resize(near.size());
    std::iota(places.begin(), places.end(), 0);
    const auto before = [&](int a, int b) { return near.sample[a] < near.sample[b]; };
    std::inplace_merge(places.begin(), places.begin() + known, places.end(), before);
    near.keep(places);
  }
  void look_at(int s) {
    N& near = pair.near;
    const SoftLayer& layer = samples.layers.empty() ? own : samples.layers[s];
    const SoftLaw& under = frame.layer().law;
    if (under.stiffness <= 0 && layer.law.stiffness <= 0)
      return pair.seen.take(s);  // both are hard
    Measured m;
    if (!reaches(s, pair.seen.triangle(s), m)) return;
    pair.seen.take(s);
    const int i = near.add(s);
    keep(m, i, near);
    near.set_law(i, in_series(under, layer.law));
    near[N::Own][i] = layer.thickness, near[N::Slack][i] = slack(s);
    near[N::Surface][i] = samples.areas[s], near[N::HalfWidth][i] = samples.half_width[s];
  }
};

}  // namespace

void find_near(const CollisionWorld& world, const SoftWorld& soft, const FoamCells& cells,
               Poses& start, double reach, double travelled, SoftPair& pair) {
  const SurfaceSamples& samples = soft.samples_of(pair.shape);
  NearSearch search{samples,
                    soft.layer_of_shape(pair.shape),
                    frame_of(world, soft, start, pair),
                    SamplePoses(world, soft, start, pair.shape),
                    reach,
                    travelled,
                    pair};
  pair.seen.resize(samples.size());
  search.look_again(pair.measured == start.stamp);
  if (travelled + reach >= pair.quiet) search.find_more();
  pair.stamp = pair.measured = start.stamp, pair.reach = reach;
  N& near = pair.near;
  search.poses.put_normals(near);
  start_step(near);
  const FoamFrame foam = foam_frame(world, start, pair);
  const double *arm = near[N::Arm], *relaxation = near[N::Relaxation];
  for (int i = 0; i < near.size(); i++) {
    if (arm[i] <= 0) continue;
    if (!near.celled[i]) near.cell[i].lie_in(foam.around(near.vector(N::At, i)));
    near.celled[i] = true;
    near[N::Gone][i] = cells.gone(relaxation[i] * (1 + arm[i]), near.cell[i]);
  }
  if (search.poses.turns()) store(near);
}

void guess_depths(double h, Vec3 v, Vec3 w, SoftPair& pair) { go_on(h, v, w, pair.near); }

bool find_depths(const CollisionWorld& world, const SoftWorld& soft, Poses& end, double way,
                 SoftPair& pair) {
  const SurfaceSamples& samples = soft.samples_of(pair.shape);
  N& near = pair.near;
  pair.measured = 0;
  std::fill(near.measured.begin(), near.measured.end(), 0);
  const double* room = near[N::Room];
  if (std::none_of(room, room + near.size(), [&](double r) { return r < way; })) {
    std::fill_n(near[N::Area], near.size(), 0.0);
    return false;
  }
  const FrameDistance frame = frame_of(world, soft, end, pair);
  const SamplePoses poses(world, soft, end, pair.shape);
  pair.measured = end.stamp;
  poses.put_points(near);
  const double within = pair.thickness + samples.pitch;
  std::fill(near.celled.begin(), near.celled.end(), 0);
  if (frame.knows_many())
    frame.measure_many(within, near);
  else
    for (int i = 0; i < near.size(); i++)
      if (room[i] < way) measure_at(frame, within, i, near);
  if (poses.turns()) poses.put_normals(near);
  face(near);
  bool any = false;
  double *area = near[N::Area], *depth = near[N::Depth], *edge = near[N::Edge];
  for (int i = 0; i < near.size(); i++) {
    if (!near.measured[i]) area[i] = 0;
    any |= depth[i] > -edge[i] && area[i] > 0;
  }
  return any;
}

PressedPart pressed_part(const NearSamples& near, int i) {
  const double depth = near[N::Depth][i], edge = near[N::Edge][i];
  // Within a step the pressed part shrinks: its pressure is that of the larger.
  const double share = (std::max(depth, near[N::Before][i]) + edge) / (2 * edge);
  if (!(share > 0 && share < 1)) return {1, depth};
  return {share, 0.5 * std::max(0.0, depth + edge)};
}

void remember(const CollisionWorld& world, const Poses& end, SoftPair& pair, FoamCells& cells) {
  const FoamFrame foam = foam_frame(world, end, pair);
  N& near = pair.near;
  const double *pressure = near[N::Pressure], *pressed = near[N::Pressed], *arm = near[N::Arm];
  const double *gone = near[N::Gone], *went = near[N::Went], *area = near[N::Area];
  for (int i = 0; i < near.size(); i++) {
    if (!(pressure[i] > 0) || arm[i] <= 0 || pressed[i] <= 0) continue;
    near.cell[i].lie_in(foam.around(near.vector(N::At, i))), near.celled[i] = true;
    cells.press(gone[i] + went[i], pressed[i] * area[i], near.cell[i]);
  }
}

void find_went(double h, SoftPair& pair) { find_went(h, pair.near); }

double given_back(double h, const SoftPair& pair) { return given_back(h, pair.near); }

void find_pressures(Rule rule, double h, SoftPair& pair) {
  rule == Rule::End ? press_to_end(h, pair.near) : press_by_mean(h, pair.near);
  pair.near.end(N::Pressure);
}

bool presses(const SoftPair& pair) {
  const double* pressure = pair.near[N::Pressure];
  return std::any_of(pressure, pressure + pair.near.size(), [](double p) { return p > 0; });
}

}  // namespace hp
