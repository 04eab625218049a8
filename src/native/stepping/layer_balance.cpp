#include "stepping/layer_balance.h"

#include <algorithm>
#include <cmath>

#include "footing/stance.h"
#include "tuning.h"

namespace hp {

namespace footing_tune = tuning::footing;

namespace {

// A person as one rigid body, at its present pose.
struct Whole {
  double mass = 0;
  Vec3 arm;      // from the root to the centre of mass [m]
  Mat3 inertia;  // about that [kg m^2]
};

Whole whole(const Inertia& inertia, int root) {
  const Inertia::Composite& c = inertia.carried(root);
  Whole out;
  out.mass = c.mass;
  out.arm = (1 / c.mass) * c.moment;
  static const int row[6] = {0, 1, 2, 0, 0, 1}, col[6] = {0, 1, 2, 1, 2, 2};
  for (int e = 0; e < 6; e++) {
    const int i = row[e], j = col[e];
    const double shift = (i == j ? norm2(out.arm) : 0) - out.arm[i] * out.arm[j];
    out.inertia.m[3 * i + j] = out.inertia.m[3 * j + i] = c.I[e] - c.mass * shift;
  }
  return out;
}

// A change of the root's velocity: of its joint, and turning, in the world.
struct Change {
  Vec3 v, w;
};

// By an impulse through the centre of mass and a moment about it.
Change pushed(const Whole& body, Vec3 impulse, Vec3 moment) {
  const Vec3 w = solve3(body.inertia, moment);
  return {(1 / body.mass) * impulse - cross(w, body.arm), w};
}

// The moment about the centre of mass that feet exert [N m], and what of the weight they carry then.
Vec3 feet_moment(OnLayers& layers, const Whole& body, Vec3 centre, Vec3 spring, double gravity) {
  const OnLayers::Feet& feet = layers.feet();
  if (!feet.on) {
    layers.feet_carry(0);
    return (footing_tune::kLyingRate * footing_tune::kLyingRate) * spring;
  }
  const double weight = body.mass * gravity;
  Vec3 lever{feet.centre.x - centre.x, feet.centre.y - centre.y, 0};
  const double length = std::max(norm(lever), 1e-9);
  const Vec3 ahead = (1 / length) * lever, about{ahead.y, -ahead.x, 0};
  spring = (footing_tune::kSeatedRate * footing_tune::kSeatedRate) * spring;
  const double more =
      dot(spring, about) / (weight * std::max(length, footing_tune::kShortestLever));
  const double share = std::clamp(feet.legs + more, 0.0, footing_tune::kMostOnFeet);
  layers.feet_carry(share);
  const double roll = weight * share * feet.breadth;
  return (weight * share * length) * about + std::clamp(dot(spring, ahead), -roll, roll) * ahead;
}

// How far the feet are from below a place, along the ground [m]; they count whatever they are on.
double feet_away(const Drive& d, const Kinematics& kin, Vec3 centre) {
  const std::vector<Leg>& legs = d.footing.model->legs;
  Vec3 feet;
  for (const Leg& leg : legs) feet += (1.0 / (double)legs.size()) * kin.xpos[leg.ankle];
  return elementary::hypot(feet.x - centre.x, feet.y - centre.y);
}

// How free the root is to turn, which leans so far off the motion [rad]: somebody upright whom no feet on the ground hold
// would fall off its seat in the end, and over feet that are below it (`away` from there), as who squats.
double turns_freely(const OnLayers& layers, Vec3 up, double leans, double away) {
  if (layers.feet().on) return 1;
  const double squats = fades(away, footing_tune::kSquats, footing_tune::kSitsBehind);
  return std::max(
      fades(std::fabs(up.z), footing_tune::kLiesFlat, footing_tune::kSitsUp),
      (1 - squats) * fades(leans, footing_tune::kLeansFreely, footing_tune::kLeansHeld));
}

}  // namespace

void balance_on_layers(System& system, Data& data, Drive& d, double h) {
  OnLayers& layers = d.footing.layers;
  std::vector<double>& v = data.step.v_free;
  const int nv = system.model.nv, first = d.first_dof(), root = d.body(0);
  std::vector<double> kept(nv, 0), change(nv, 0), momentum(nv, 0), reference(nv, 0);
  d.unhindered(kept.data());
  double most = 0;
  for (int i = first; i < first + d.dof_count(); i++) {
    change[i] = v[i] - kept[i];
    most = std::max(most, std::fabs(change[i]));
  }
  const double r = layers.rest();
  const bool driven = most >= tuning::stepping::kVelocityRounding;
  if (!driven && r == 0) return;
  data.inertia.compose(system, data.state);
  // The drive's: up and down without momentum from nowhere.
  data.inertia.multiply(system, d, change.data(), momentum.data());
  if (driven) v[first + 2] -= momentum[first + 2] / system.model.carried[root] - change[first + 2];
  if (r == 0) return;
  // And that of a body which is free.
  const Mat3 R = data.state.pose.kin.xmat[root];
  const Quat off = data.state.pose.kin.xquat[root] * conjugate(d.motion.after(d.balls()[0]));
  const Vec3 turned = log_quat(off);
  const Whole body = whole(data.inertia.inertia(), root);
  const Vec3 centre = data.state.pose.kin.xpos[root] + body.arm;
  const double turns = turns_freely(layers, R.col(1), elementary::hypot(turned.x, turned.y),
                                    feet_away(d, data.state.pose.kin, centre));
  for (int i = 0; i < 6; i++) change[first + i] *= i < 3 ? 0 : 1 - turns;
  data.inertia.multiply(system, d, change.data(), momentum.data());
  d.reference(reference.data());
  const Vec3 linear = load3(&momentum[first]);
  const Vec3 angular = R * load3(&momentum[first + 3]) - cross(body.arm, linear);
  Vec3 spring = -(body.inertia * turned);
  spring.z = 0;  // friction holds how it lies
  const Vec3 held = feet_moment(layers, body, centre, spring, norm(system.gravity));
  const double share = h / d.scale(system.drive_settings, h);
  const Change free = pushed(body, -linear, turns * (share * held - angular));
  const Vec3 w = to_matrix(conjugate(data.state.pose.kin.xquat[root])) * free.w;
  const double keeps = elementary::exp(-footing_tune::kLayerDamping * h);
  for (int c = 0; c < 6; c++) {
    const int i = first + c;
    const double alone = reference[i] + keeps * (kept[i] - reference[i]);
    const double driven_turn = c < 3 ? 0 : (1 - turns) * (v[i] - alone);
    v[i] += r * (alone + driven_turn + (c < 3 ? free.v[c] : w[c - 3]) - v[i]);
  }
}

}  // namespace hp
