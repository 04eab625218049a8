#include "soft/pressing.h"

#include <algorithm>
#include <cmath>

#include "tuning.h"

namespace hp {

namespace tune = tuning::soft;

SamplePoses::SamplePoses(const CollisionWorld& world, const SoftWorld& soft, Poses& pose, int shape)
    : samples_(soft.samples_of(shape)), shape_(world.shapes[shape]), pose_(pose) {
  if (shape_.skin) points_ = world.place(pose, shape).points();
}

Vec3 SamplePoses::position(int sample) const {
  if (shape_.skin) return points_.at(samples_.vertex[sample]);
  const int b = shape_.body;
  return pose_.kin.xpos[b] + pose_.kin.xmat[b] * samples_.points[sample];
}

Vec3 SamplePoses::normal(int sample) const {
  const Vec3& rest = samples_.normals[sample];
  if (!shape_.skin) return pose_.kin.xmat[shape_.body] * rest;
  Vec3 n;
  for (int e = samples_.first_carrier[sample]; e < samples_.first_carrier[sample + 1]; e++)
    n += samples_.carriers[e].weight * (pose_.kin.xmat[samples_.carriers[e].body] * rest);
  const double length = norm(n);
  return length > tune::kNoDistance ? (1 / length) * n : pose_.kin.xmat[shape_.body] * rest;
}

FrameDistance frame_of(const CollisionWorld& world, const SoftWorld& soft, Poses& pose,
                       const SoftPair& pair) {
  return pair.other_static >= 0 ? FrameDistance::of_static(world, soft, pair.other_static)
                                : FrameDistance::of_shape(world, soft, pose, pair.other_shape);
}

namespace {

// Half of the depths' spread over the piece of surface of area A that a sample stands for.
double spread(double area, double cosine) {
  return std::max(tune::kLeastEdge, 0.5 * std::sqrt(area * std::max(0.0, 1 - cosine * cosine)));
}

// Where a sample's hard point is, and how far from the frame. False: farther than `within`.
bool measure(const SamplePoses& poses, const FrameDistance& frame, double within, NearSample& s) {
  s.hard = poses.position(s.sample);
  s.measured = frame.nearest(s.hard, within, s.frame.triangle, s.frame);
  return s.measured;
}

// Depth and area of a sample that was measured, by its normal.
void face(double area, NearSample& s) {
  const double cosine = std::clamp(-dot(s.normal, s.frame.n), 0.0, 1.0);
  // What presses is the point of the unloaded surface above the hard point.
  s.x = s.y = s.hard + s.own * s.normal, s.n = s.frame.n;
  s.depth = s.frame.thickness + s.own * cosine - s.frame.distance;
  s.edge = spread(area, cosine);
  // What is askew is pressed in by less, of foam that is no thinner; nor than its depths spread.
  s.thickness = std::max(s.frame.thickness + s.own, s.edge);
  s.area = area * cosine;
}

// Means over the depths d - e to d + e of the springs' pressure, of its slope, and of their energy.
struct Spread {
  const SoftLaw& law;
  double t, e;

  struct Mean {
    double pressure, slope;
  };
  Mean mean(double d) const {
    const Springs a = law.springs(d + e, t), b = law.springs(d - e, t);
    const double whole = 1 / (2 * e);
    return {(a.energy - b.energy) * whole, (a.pressure - b.pressure) * whole};
  }
  double energy(double d) const {
    return (law.energy_sum(d + e, t) - law.energy_sum(d - e, t)) / (2 * e);
  }
  // The share of the piece that is pressed.
  double share(double d) const { return std::clamp((d + e) / (2 * e), 0.0, 1.0); }
};

// The energy [J] at its depth, where the dashpot of the Maxwell arm has gone q [m].
double stored(double q, const NearSample& s) {
  if (s.area <= 0 || s.depth <= -s.edge) return 0;
  const Spread at{s.law, s.thickness, s.edge};
  const double arm = std::max(0.0, s.depth - q);
  return s.area *
         (at.energy(s.depth) + 0.5 * at.share(s.depth) * s.law.arm * s.law.stiffness * arm * arm);
}

// How far the dashpot of the Maxwell arm goes in a step of length h [m].
double arm_way(double h, const NearSample& s) {
  if (!(s.pressure > 0) || s.law.arm <= 0 || s.pressed <= 0) return 0;
  return h / s.law.relaxation * s.arm / (s.law.arm * s.law.stiffness * s.pressed);
}

}  // namespace

FoamPlace foam_place(const CollisionWorld& world, const Poses& pose, const SoftPair& pair) {
  if (pair.other_static >= 0) return {pair.other_static, {}, {}};
  const int b = world.shapes[pair.other_shape].body;
  return {-pair.other_shape - 1, pose.kin.xpos[b], pose.kin.xmat[b]};
}

namespace {

// The samples of a pair at the start of a step.
struct NearSearch {
  const SurfaceSamples& samples;
  const SoftLayer& own;
  FrameDistance frame;
  SamplePoses poses;
  double asked, room, travelled;  // asked for, measured as far as [m]
  SoftPair& pair;

  // Measures; what is out of reach is noted, and false.
  bool reaches(NearSample& s) {
    const double thick = pair.thickness;
    const bool found = measure(poses, frame, thick + room, s);
    return note(s, found ? s.frame.distance - thick : room);
  }
  bool note(const NearSample& s, double off) {
    if (off <= asked) return true;
    pair.seen[s.sample] = {off, travelled, s.frame.triangle};
    pair.quiet = std::min(pair.quiet, off + travelled);
    return false;
  }

  // Those that were near, in place.
  void look_again(bool kept) {
    const auto leaves = [&](NearSample& s) {
      const bool known = kept && s.measured;
      return known ? !note(s, s.frame.distance - pair.thickness) : !reaches(s);
    };
    pair.near.erase(std::remove_if(pair.near.begin(), pair.near.end(), leaves), pair.near.end());
  }

  // The others.
  void find_more() {
    const size_t known = pair.near.size();
    size_t next = 0;
    pair.quiet = 1e300;
    pair.seen.resize(samples.size());
    for (int i = 0; i < samples.size(); i++) {
      if (next < known && pair.near[next].sample == i) {
        next++;
        continue;
      }
      const SeenSample& seen = pair.seen[i];
      if (seen.room - (travelled - seen.at) > asked) {
        pair.quiet = std::min(pair.quiet, seen.room + seen.at);
        continue;
      }
      NearSample s;
      const SoftLayer& layer = samples.layers.empty() ? own : samples.layers[i];
      s.law = in_series(frame.layer().law, layer.law);
      if (s.law.stiffness <= 0) continue;  // both are hard here
      s.sample = i, s.own = layer.thickness, s.frame.triangle = seen.triangle;
      if (reaches(s)) pair.near.push_back(s);
    }
    std::inplace_merge(
        pair.near.begin(), pair.near.begin() + (long)known, pair.near.end(),
        [](const NearSample& a, const NearSample& b) { return a.sample < b.sample; });
  }
};

}  // namespace

void find_near(const CollisionWorld& world, const SoftWorld& soft, const FoamCells& cells,
               Poses& start, double reach, double travelled, SoftPair& pair) {
  const SurfaceSamples& samples = soft.samples_of(pair.shape);
  const double asked = reach + samples.pitch;
  NearSearch search{samples,
                    soft.layer_of_shape(pair.shape),
                    frame_of(world, soft, start, pair),
                    SamplePoses(world, soft, start, pair.shape),
                    asked,
                    asked + tune::kSeenMargin,
                    travelled,
                    pair};
  search.look_again(pair.measured == start.stamp);
  if (travelled + asked >= pair.quiet) search.find_more();
  pair.stamp = pair.measured = start.stamp, pair.reach = reach;
  const FoamPlace place = foam_place(world, start, pair);
  for (NearSample& s : pair.near) {
    s.normal = search.poses.normal(s.sample);
    face(samples.areas[s.sample], s);
    s.before = s.depth, s.first = s.x;
    if (s.law.arm > 0) s.gone = cells.gone(place.layer, place.local(s.frame.at), s.law, s.cell);
    if (search.poses.turns()) s.stored = stored(s.gone, s);
  }
}

void act_between(Vec3 from, Vec3 to, SoftPair& pair) {
  for (NearSample& s : pair.near) s.y = 0.5 * (s.x + s.first + (to - from));
}

void guess_depths(double h, Vec3 v, Vec3 w, SoftPair& pair) {
  for (NearSample& s : pair.near) {
    s.depth = s.before - h * dot(s.n, v + cross(w, s.first));
    s.y = s.first;
  }
}

bool find_depths(const CollisionWorld& world, const SoftWorld& soft, Poses& end, double way,
                 SoftPair& pair) {
  const SurfaceSamples& samples = soft.samples_of(pair.shape);
  const auto reaches = [&](const NearSample& s) { return s.before + way + samples.pitch > 0; };
  pair.measured = 0;
  for (NearSample& s : pair.near) s.area = 0, s.measured = false;
  if (std::none_of(pair.near.begin(), pair.near.end(), reaches)) return false;
  const FrameDistance frame = frame_of(world, soft, end, pair);
  const SamplePoses poses(world, soft, end, pair.shape);
  pair.measured = end.stamp;
  bool any = false;
  for (NearSample& s : pair.near) {
    if (!reaches(s)) continue;
    if (!measure(poses, frame, pair.thickness + samples.pitch, s)) {
      s.depth = -1e300;
      continue;
    }
    if (poses.turns()) s.normal = poses.normal(s.sample);
    face(samples.areas[s.sample], s);
    any |= s.depth > -s.edge && s.area > 0;
  }
  return any;
}

namespace {

void press_to_end(const Spread& at, double h, NearSample& s) {
  const SoftLaw& law = s.law;
  const double share = s.pressed = at.share(s.depth);
  const double arm = law.arm > 0 ? law.arm * law.stiffness / (1 + h / law.relaxation) : 0;
  const Spread::Mean springs = at.mean(s.depth);
  s.arm = share * arm * (s.depth - s.gone);
  s.pressure = springs.pressure + share * law.damping * (s.depth - s.before) / h + s.arm;
  s.slope = springs.slope + share * (law.damping / h + arm);
}

void press_by_mean(const Spread& at, double h, NearSample& s) {
  const SoftLaw& law = s.law;
  const double way = s.depth - s.before, middle = s.before + 0.5 * way;
  const double share = s.pressed = at.share(middle);
  const double arm = law.arm * law.stiffness / (1 + 0.5 * h / law.relaxation);
  if (std::fabs(way) > tune::kNoIndent) {
    s.pressure = (at.energy(s.depth) - at.energy(s.before)) / way;
    s.slope = (at.mean(s.depth).pressure - s.pressure) / way;
  } else {
    const Spread::Mean springs = at.mean(middle);
    s.pressure = springs.pressure;
    s.slope = 0.5 * springs.slope;
  }
  s.arm = share * arm * (middle - s.gone);
  s.pressure += share * law.damping * way / h + s.arm;
  s.slope += share * (law.damping / h + 0.5 * arm);
}

}  // namespace

PressedPart pressed_part(const NearSample& s) {
  // Within a step the pressed part shrinks: its pressure is that of the larger.
  const double share = (std::max(s.depth, s.before) + s.edge) / (2 * s.edge);
  if (!(share > 0 && share < 1)) return {1, s.depth};
  return {share, 0.5 * std::max(0.0, s.depth + s.edge)};
}

void remember(const CollisionWorld& world, const Poses& end, double h, const SoftPair& pair,
              FoamCells& cells) {
  const FoamPlace place = foam_place(world, end, pair);
  for (const NearSample& s : pair.near) {
    if (!(s.pressure > 0) || s.law.arm <= 0 || s.pressed <= 0) continue;
    cells.press(place.layer, place.local(s.frame.at), s.gone + arm_way(h, s), s.pressed * s.area,
                s.cell);
  }
}

double given_back(double h, const SoftPair& pair) {
  double sum = 0;
  for (const NearSample& s : pair.near) {
    const double went = arm_way(h, s), springs = s.stored - stored(s.gone + went, s);
    if (s.pressure > 0) {
      const double way = s.depth - s.before;
      sum += springs - s.area * (s.pressed * s.law.damping * way * way / h + s.arm * went);
    } else {
      sum += std::min(0.0, springs);  // what does not push gives nothing
    }
  }
  return sum;
}

void find_pressures(Rule rule, double h, SoftPair& pair) {
  for (NearSample& s : pair.near) {
    s.pressure = s.slope = s.arm = s.pressed = 0;
    if (s.area <= 0 || std::max(s.depth, s.before) <= -s.edge) continue;
    const Spread at{s.law, s.thickness, s.edge};
    if (rule == Rule::End)
      press_to_end(at, h, s);
    else
      press_by_mean(at, h, s);
    if (!(s.pressure > 0)) s.pressure = s.slope = 0;
  }
}

}  // namespace hp
