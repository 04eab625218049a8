#include "footing/underfoot.h"

#include "tuning.h"

namespace hp {

namespace tune = tuning::footing;

namespace {

// How far below the surface without load a part is put on a layer, so that contacts carry it [m].
double dips(const Surface& s) { return std::min(tune::kDips, tune::kDipsShare * s.layer); }

// Thickness of soft skin, by the body that a shape is on; empty: no person has any.
std::vector<double> soft_skin(const CollisionWorld& world) {
  std::vector<double> layer;
  for (const CollisionShape& shape : world.shapes) {
    if (shape.person < 0 || shape.layer <= 0) continue;
    if ((int)layer.size() <= shape.body) layer.resize(shape.body + 1, 0);
    layer[shape.body] = std::max(layer[shape.body], shape.layer);
  }
  return layer;
}

// How far above a point of a sole what it steps on may be, which is `high` above the person's lowest, and whose
// foot rests on ground `stands` above it [m].
double step_up(double high, double stands) {
  const double swings = std::max(tune::kStepsOver, tune::kStepFrom - high);
  return std::min({tune::kStepUp, swings, stands + tune::kCreepsUp});
}

// Height of the lowest of `count` points from `first` on [m].
double lowest_of(const std::vector<Vec3>& points, size_t first, size_t count) {
  double lowest = 1e300;
  for (size_t i = first; i < first + count; i++) lowest = std::min(lowest, points[i].z);
  return lowest;
}

// How far above the ground a sole stands [m].
double above(const CollisionWorld& world) { return world.settings.clearance + tune::kSoleGap; }

// Where a sole stands on a surface [m]: on a layer just below its own.
double stands_on(const Surface& s, const CollisionWorld& world) {
  return s.layer > 0 ? s.top() - dips(s) : s.height + above(world);
}

}  // namespace

void Underfoot::find(const CollisionWorld& world, Poses& poses, const FootingModel& model,
                     const Stance& stance, const Footwork& work, Vec3 displaced, double height,
                     Bearing& bearing) {
  SurfaceBelow below(world, stance.own());
  size_t i = 0;
  ground.clear();
  std::vector<double> stands;  // where each point of the soles stands on what is below it [m]
  const double lowest = lowest_of(stance.points, 0, stance.points.size());  // of the reference
  const std::vector<Foot> before = std::move(feet);
  feet.assign(model.legs.size(), {});
  bearing.points.assign(stance.points.size(), {});
  for (size_t f = 0; f < model.legs.size(); f++) {
    // Steps are measured from where the motion has the foot: who stands on one does not climb the next.
    const Vec3 by = Vec3{displaced.x, displaced.y, height} + work.offset(f);
    const bool rests = stance.feet[f].rests > tune::kAtRestShare;
    const double from = rests && f < before.size() ? before[f].stands : 1e300;
    double highest = -1e300;
    feet[f].soon.fill(-1e300);
    const size_t first = i, count = model.legs[f].sole.size();
    const double high = lowest_of(stance.points, first, count) + tune::kHigh;
    for (; i < first + count; i++) {
      const Vec3 x = stance.points[i];
      const double up = step_up(x.z - lowest, from - (x + by).z);
      // What the raised part of a tilted sole is against, it pushes.
      const Surface s = x.z > high ? below.find_static_footing(x + by, up, tune::kDeep)
                                   : below.find_footing(poses, x + by, up, tune::kDeep);
      ground.push_back(s.found ? s.height + above(world) : -1e300);
      stands.push_back(-1e300);
      if (!s.found) continue;
      bearing.points[i] = {{0, 0, s.height}, s.shape, 1, s.layer > 0};
      feet[f].grounded = true;
      highest = std::max(highest, s.height);
      feet[f].least = std::max(feet[f].least, ground.back() - x.z);
      stands.back() = stands_on(s, world);
      feet[f].lift = std::max(feet[f].lift, stands.back() - x.z);
    }
    if (!rests) look_ahead(world, stance, below, stands, first, high, by, lowest, feet[f]);
    feet[f].least = std::min(feet[f].least, feet[f].lift);
    if (rests && feet[f].grounded) feet[f].stands = highest;
  }
  // Skin is seen from where contacts hold the person up.
  find_skin(world, poses, model, stance,
            {displaced.x, displaced.y, height + std::max(0.0, displaced.z)}, bearing);
}

// What a foot that swings, its points from `first` on and up to `high` moved by `by`, comes to in the next moments that is
// higher than what is under it; the reference's lowest point is at `lowest`. Static geometry: objects that it comes to
// it pushes ahead.
void Underfoot::look_ahead(const CollisionWorld& world, const Stance& stance, SurfaceBelow& below,
                           const std::vector<double>& stands, size_t first, double high, Vec3 by,
                           double lowest, Foot& foot) {
  for (size_t i = first; i < stands.size(); i++) {
    const Vec3 x = stance.points[i];
    if (stands[i] == -1e300 || x.z > high) continue;
    double looked = 0;
    for (int k = 0; k < tune::kLooks; k++) {
      const double time = (k + 1) * tune::kLookTime;
      const Vec3 way = stance.goes(i, time);
      if (norm(way) < looked + tune::kLookWay) continue;
      if (norm(way) > tune::kLookFar) break;
      looked = norm(way);
      // Where it may come there first.
      const double rises = (time - tune::kLookTime) * std::max(0.0, stance.rises(i));
      const double from = x.z + rises, up = step_up(from - lowest, 1e300);
      const Vec3 to = Vec3{x.x, x.y, from} + by + way;
      const double most = std::max(stands[i] + tune::kSameLevel, foot.soon[k] + from);
      const Surface s = below.find_static_footing(to, up, to.z - (most - above(world)));
      if (s.found && stands_on(s, world) > most) foot.soon[k] = stands_on(s, world) - from;
    }
  }
}

double Underfoot::ground_at(const CollisionWorld& world, Poses& poses, SurfaceBelow& below,
                            size_t point, Vec3 x) const {
  x.z = ground[point] - above(world);
  const Surface s = below.find(poses, x, tune::kSameLevel, tune::kSameLevel);
  return s.found ? s.height + above(world) : -1e300;
}

// The lift that skin needs which rests on something, or presses on it.
void Underfoot::find_skin(const CollisionWorld& world, Poses& poses, const FootingModel& model,
                          const Stance& stance, Vec3 by, Bearing& bearing) {
  SurfaceBelow below(world, stance.own());
  skin_lift_ = least_skin_lift_ = -1e300;
  const std::vector<double> skin = soft_skin(world);
  const size_t soles = stance.points.size() - model.skin.size();
  for (size_t n = 0; n < model.skin.size(); n++) {
    const size_t i = soles + n;
    if (stance.speed[i] > tune::kMoves || model.skin[n].facing(stance.kin).z > -tune::kFaces)
      continue;
    const Vec3 x = stance.points[i];
    Surface s = below.find(poses, x + by, tune::kPressedIn, tune::kCarries);
    if (!s.found) continue;
    const int body = model.skin[n].body[0];
    if (body < (int)skin.size()) s.height -= skin[body], s.layer += skin[body];
    bearing.points[i] = {{0, 0, s.height}, s.shape, 1, s.layer > 0};
    const double frame = s.height + world.settings.clearance - x.z;
    least_skin_lift_ = std::max(least_skin_lift_, frame);
    skin_lift_ = std::max(skin_lift_, s.layer > 0 ? s.top() - dips(s) - x.z : frame);
  }
}

double Underfoot::highest() const {
  double height = -1e300;
  for (double z : ground) height = std::max(height, z);
  return height;
}

double Underfoot::least_height(const CollisionWorld& world, const FootingModel& model,
                               const Stance& stance, Vec3 by, bool hands) {
  SurfaceBelow below(world, stance.own());
  double least = -1e300;
  auto look = [&](Vec3 x) {
    const Surface s = below.find_static(x + by, tune::kNotSunk, tune::kDeep);
    if (s.found) least = std::max(least, s.height + world.settings.clearance - x.z);
  };
  const size_t soles = stance.points.size() - model.skin.size();
  for (size_t n = 0; n < model.skin.size(); n++) look(stance.points[soles + n]);
  for (size_t n = 0; n < model.hands.size() && hands; n++)
    look(model.hands[n].position(stance.kin));
  return least;
}

bool Underfoot::lands(const CollisionWorld& world, Poses& poses, const Leg& leg,
                      const Stance& stance, Vec3 by, double turn) {
  SurfaceBelow below(world, stance.own());
  const Kinematics& kin = stance.kin;
  const Vec3 ankle = kin.xpos[leg.ankle];
  const Mat3 turned = to_matrix(exp_quat({0, 0, turn}));
  double lowest = 1e300;
  for (const SkinPoint& p : leg.sole) lowest = std::min(lowest, p.position(kin).z);
  for (const SkinPoint& p : leg.sole) {
    Vec3 x = ankle + turned * (p.position(kin) - ankle) + by;
    x.z = lowest + by.z;
    if (!below.find(poses, x, tune::kLandsUp, tune::kLandsDown).found) return false;
  }
  return true;
}

}  // namespace hp
