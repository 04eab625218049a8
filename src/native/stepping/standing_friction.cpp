#include "stepping/standing_friction.h"

#include <algorithm>
#include <cmath>

#include "stepping/standing_load.h"
#include "tuning.h"

namespace hp {

namespace tune = tuning::stepping;

StandingFriction::Patch& StandingFriction::patch(int shape, int body) {
  for (Patch& p : patches_)
    if (p.shape == shape && p.body == body) return p;
  patches_.emplace_back();
  patches_.back().shape = shape, patches_.back().body = body;
  return patches_.back();
}

// The patches of one person.
void StandingFriction::collect(const System& system, const Drive& d) {
  patches_.clear();
  const double weight = weight_of(system, d);
  const auto each = [&](const auto& act) {
    for_loads(system, d, [&](size_t i, int, double share) {
      const BearingPoint& point = d.footing.bearing.points[i];
      if (!point.timed || share < tune::kStandingShare) return;
      act(patch(point.shape, d.footing.model->bearing_body(i)), point, share * weight);
    });
  };
  each([](Patch& p, const BearingPoint& point, double force) {
    p.force += force;
    p.gap = std::min(p.gap, point.gap);
    p.at += force * point.at;
    p.velocity += force * point.velocity;
  });
  for (Patch& p : patches_) p.at = (1 / p.force) * p.at, p.velocity = (1 / p.force) * p.velocity;
  each([](Patch& p, const BearingPoint& point, double force) {
    const Vec3 r = point.at - p.at, v = point.velocity - p.velocity;
    p.xx += force * r.x * r.x, p.xy += force * r.x * r.y, p.yy += force * r.y * r.y;
    p.turning += force * (r.x * v.y - r.y * v.x);
  });
}

void StandingFriction::add_rows(const System& system, const Patch& patch, double h, double whole,
                                std::vector<StandingRow>& rows) {
  const World& world = system.world;
  const int person = pressing_shape(system, patch.body);
  const Pairing& pairing = world.pairing(world.shapes[person].name, world.shapes[patch.shape].name);
  if (pairing.friction <= 0 || pairing.ignore || patch.gap >= tune::kHoldsNot) return;
  const double moment = patch.xx + patch.yy, radius = std::sqrt(moment / patch.force);
  const bool wide = radius > tune::kStandingPoint;
  const double angle = 0.5 * elementary::atan2(2 * patch.xy, patch.xx - patch.yy);
  Vec3 arm;
  elementary::sin_cos(angle, arm.y, arm.x);
  arm = wide ? radius * arm : Vec3{};
  const double turning = wide ? patch.turning / moment : 0;
  for (int side = -1; side <= (wide ? 1 : -1); side += 2) {
    const Vec3 r = side * arm;
    StandingRow row;
    row.shape = patch.shape, row.person = person;
    row.sole = patch.velocity + Vec3{-turning * r.y, turning * r.x, 0};
    Contact& c = row.contact;
    c.t = {1, 0, 0}, c.s = {0, 1, 0};
    c.position = c.at_a = c.at_b = patch.at + r;
    c.a = Endpoint::rigid(world.shapes[patch.shape].body, c.position);
    c.curve = (-1 / h) * row.sole;  // so far the sole goes meanwhile
    c.friction = pairing.friction * fades(patch.gap, tune::kHolds, tune::kHoldsNot);
    c.compliance = 1;
    c.yielding = whole * patch.force * (wide ? 0.5 : 1);
    rows.push_back(row);
  }
}

void StandingFriction::find(const System& system, Data& data, double h) {
  std::vector<StandingRow>& rows = data.attempt.standing;
  rows.clear();
  // What goes on after a part of its step has the friction of all of it.
  if (data.step.gravity_time == 0) return;
  for (const Drive& d : system.drives) {
    if (!d.footing.on() || !d.footing.bearing.any()) continue;
    collect(system, d);
    for (const Patch& p : patches_) add_rows(system, p, h, data.step.length, rows);
  }
}

void StandingFriction::look(const System& system, Data& data) {
  Attempt& attempt = data.attempt;
  if (attempt.standing.empty()) return;
  const Kinematics& kin = data.state.pose.kin;
  const double* v_free = data.step.v_free.data();
  body_twists(system.model, kin, v_free, twists_);
  for (const StandingRow& row : attempt.standing) {
    const Contact& c = row.contact;
    const Vec3 w = endpoint_velocity(system.model, kin, twists_, v_free, c.a) - row.sole;
    if (elementary::hypot(w.x, w.y) > tune::kStandingSlip)
      attempt.islands[data.islands.of_row(system, c)].violated = true;
  }
}

void StandingFriction::record(const System& system, Data& data, const std::vector<double>& share) {
  for (const StandingRow& row : data.attempt.standing) {
    const Contact& c = row.contact;
    const int root = system.tree(row.shape);
    if (norm2(c.impulse) == 0 || (!share.empty() && share[root] < 0)) continue;
    data.result.disturbed[root] = 1;
    if (data.result.keep_points)
      data.result.points.push_back(
          {row.person, -1, row.shape, c.position, {0, 0, 1}, -1 * c.impulse, 0});
  }
}

}  // namespace hp
