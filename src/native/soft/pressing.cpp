#include "soft/pressing.h"

#include <algorithm>
#include <cmath>

#include "tuning.h"

namespace hp {

namespace tune = tuning::soft;

SamplePoses::SamplePoses(const CollisionWorld& world, const SoftWorld& soft, Poses& pose, int shape)
    : samples_(soft.samples_of(shape)), shape_(world.shapes[shape]), pose_(pose) {
  if (shape_.skin) posed_ = &world.place(pose, shape);
}

Vec3 SamplePoses::position(int sample) const {
  if (posed_) return posed_->points().at(samples_.vertex[sample]);
  const int b = shape_.body;
  return pose_.kin.xpos[b] + pose_.kin.xmat[b] * samples_.points[sample];
}

Vec3 SamplePoses::normal(int sample) const {
  const Vec3& rest = samples_.normals[sample];
  if (!posed_) return pose_.kin.xmat[shape_.body] * rest;
  const Skin& skin = *shape_.skin;
  const int v = shape_.vertex[samples_.vertex[sample]];
  Vec3 n;
  for (int e = skin.first_weight[v]; e < skin.first_weight[v + 1]; e++)
    n += skin.weight[e] * (pose_.kin.xmat[skin.body[skin.weight_joint[e]]] * rest);
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

enum class Seen : char { Far, Away, Near };

// Measures one sample at a pose; Far: it is farther than `within` from the frame.
Seen look(const SamplePoses& poses, const FrameDistance& frame, const SurfaceSamples& samples,
          double within, NearSample& s) {
  const Vec3 x = poses.position(s.sample);
  FramePoint p;
  if (!frame.nearest(x, within, s.triangle, p)) return Seen::Far;
  if (poses.turns() || norm2(s.normal) == 0) s.normal = poses.normal(s.sample);
  const double facing = -dot(s.normal, p.n), cosine = std::clamp(facing, 0.0, 1.0);
  const double area = samples.areas[s.sample];
  // What presses is the point of the unloaded surface above the hard point.
  s.x = s.y = x + s.own * s.normal, s.n = p.n, s.at = p.at, s.triangle = p.triangle;
  s.depth = p.thickness + s.own * cosine - p.distance;
  s.edge = spread(area, cosine);
  // What is askew is pressed in by less, of foam that is no thinner; nor than its depths spread.
  s.thickness = std::max(p.thickness + s.own, s.edge);
  s.area = area * cosine;
  return facing < tune::kFacesAway ? Seen::Away : Seen::Near;
}

}  // namespace

FoamPlace foam_place(const CollisionWorld& world, const Poses& pose, const SoftPair& pair) {
  if (pair.other_static >= 0) return {pair.other_static, {}, {}};
  const int b = world.shapes[pair.other_shape].body;
  return {-pair.other_shape - 1, pose.kin.xpos[b], pose.kin.xmat[b]};
}

namespace {

// Need a sample not be measured again: is it out of reach, or facing away, by what was seen of it?
bool stays_out(const SeenSample& seen, double reach, double travelled) {
  const double since = travelled - seen.at;
  return seen.depth + since + reach < 0 || (seen.away && since < tune::kTurningWay);
}

}  // namespace

void find_near(const CollisionWorld& world, const SoftWorld& soft, const FoamCells& cells,
               Poses& start, double reach, double travelled, SoftPair& pair) {
  pair.stamp = start.stamp, pair.reach = reach;
  pair.near.clear();
  const SurfaceSamples& samples = soft.samples_of(pair.shape);
  pair.seen.resize(samples.size());
  const FrameDistance frame = frame_of(world, soft, start, pair);
  const SamplePoses poses(world, soft, start, pair.shape);
  const SoftLayer& own = soft.layer_of_shape(pair.shape);
  const FoamPlace place = foam_place(world, start, pair);
  const double room = reach + samples.pitch + tune::kSeenMargin;
  for (int i = 0; i < samples.size(); i++) {
    SeenSample& seen = pair.seen[i];
    if (stays_out(seen, reach + samples.pitch, travelled)) continue;
    const SoftLayer& layer = samples.layers.empty() ? own : samples.layers[i];
    NearSample s;
    s.sample = i, s.own = layer.thickness, s.triangle = seen.triangle;
    const Seen found = look(poses, frame, samples, pair.thickness + room, s);
    // Turned toward the layer, it has all of its own thickness.
    seen = {found == Seen::Far ? -room : s.depth + s.own, travelled, found == Seen::Away,
            s.triangle};
    if (found != Seen::Near || s.depth + reach + samples.pitch < 0) continue;
    s.law = in_series(frame.layer().law, layer.law);
    if (s.law.stiffness <= 0) continue;  // both are hard here
    s.before = s.depth, s.first = s.x;
    if (s.law.arm > 0) s.gone = cells.gone(place.layer, place.local(s.at), s.law);
    pair.near.push_back(s);
  }
}

void act_between(Vec3 from, Vec3 to, SoftPair& pair) {
  for (NearSample& s : pair.near) s.y = 0.5 * (s.x + s.first + (to - from));
}

bool find_depths(const CollisionWorld& world, const SoftWorld& soft, Poses& end, double way,
                 SoftPair& pair) {
  const SurfaceSamples& samples = soft.samples_of(pair.shape);
  const auto reaches = [&](const NearSample& s) { return s.before + way + samples.pitch > 0; };
  for (NearSample& s : pair.near) s.area = 0;
  if (std::none_of(pair.near.begin(), pair.near.end(), reaches)) return false;
  const FrameDistance frame = frame_of(world, soft, end, pair);
  const SamplePoses poses(world, soft, end, pair.shape);
  bool any = false;
  for (NearSample& s : pair.near) {
    if (!reaches(s)) continue;
    if (look(poses, frame, samples, pair.thickness + samples.pitch, s) != Seen::Near) {
      s.depth = -1e300, s.area = 0;
      continue;
    }
    any |= s.depth > -s.edge && s.area > 0;
  }
  return any;
}

namespace {

// Means over the depths d - e to d + e of the springs' pressure, of its slope, and of their energy.
struct Spread {
  const SoftLaw& law;
  double t, e;

  double pressure(double d) const {
    return (law.energy(d + e, t) - law.energy(d - e, t)) / (2 * e);
  }
  double slope(double d) const {
    return (law.pressure(d + e, t) - law.pressure(d - e, t)) / (2 * e);
  }
  double energy(double d) const {
    return (law.energy_sum(d + e, t) - law.energy_sum(d - e, t)) / (2 * e);
  }
  // The share of the piece that is pressed.
  double share(double d) const { return std::clamp((d + e) / (2 * e), 0.0, 1.0); }
};

void press_to_end(const Spread& at, double h, NearSample& s) {
  const SoftLaw& law = s.law;
  const double share = s.pressed = at.share(s.depth);
  const double arm = law.arm * law.stiffness / (1 + h / law.relaxation);
  s.arm = share * arm * (s.depth - s.gone);
  s.pressure = at.pressure(s.depth) + share * law.damping * (s.depth - s.before) / h + s.arm;
  s.slope = at.slope(s.depth) + share * (law.damping / h + arm);
}

void press_by_mean(const Spread& at, double h, NearSample& s) {
  const SoftLaw& law = s.law;
  const double way = s.depth - s.before, middle = s.before + 0.5 * way;
  const double share = s.pressed = at.share(middle);
  const double arm = law.arm * law.stiffness / (1 + 0.5 * h / law.relaxation);
  if (std::fabs(way) > tune::kNoIndent) {
    s.pressure = (at.energy(s.depth) - at.energy(s.before)) / way;
    s.slope = (at.pressure(s.depth) - s.pressure) / way;
  } else {
    s.pressure = at.pressure(middle);
    s.slope = 0.5 * at.slope(middle);
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
    const double went = h / s.law.relaxation * s.arm / (s.law.arm * s.law.stiffness * s.pressed);
    cells.press(place.layer, place.local(s.at), s.gone + went, s.pressed * s.area);
  }
}

void find_pressures(Rule rule, double h, SoftPair& pair) {
  for (NearSample& s : pair.near) {
    s.pressure = s.slope = s.arm = s.pressed = 0;
    if (s.area <= 0) continue;
    const Spread at{s.law, s.thickness, s.edge};
    if (rule == Rule::End)
      press_to_end(at, h, s);
    else
      press_by_mean(at, h, s);
    if (!(s.pressure > 0)) s.pressure = s.slope = 0;
  }
}

}  // namespace hp
