#include "support/wrench_spread.h"

#include <algorithm>
#include <cmath>

#include "math/dense.h"

namespace hp {

namespace {

// A vector of forces and scaled moments.
struct Wrench {
  Vec3 force, moment;
};

double dot(const Wrench& a, const Wrench& b) {
  return dot(a.force, b.force) + dot(a.moment, b.moment);
}

Wrench moved(const Wrench& y, double length, const Wrench& way) {
  return {y.force + length * way.force, y.moment + length * way.moment};
}

// Where g lies in the cone of a place, and its projection on it. `across` is the tangential part of
// g over the shear weight s: with tangential forces times s the weight of a force is its square, and
// the cone one of friction s mu. `square` is that of the force.
struct Projection {
  Vec3 force, across;
  double pushes, size, square;
  bool slips;
};

Projection project(const CarryingPlace& place, double shear, Vec3 g) {
  const double along = dot(g, place.normal), mu = shear * place.friction;
  Projection p;
  p.across = (1 / shear) * (g - along * place.normal);
  p.size = norm(p.across);
  p.slips = p.size > mu * along;
  p.pushes = p.slips ? std::max(along + mu * p.size, 0.0) / (1 + mu * mu) : along;
  const double held = !p.slips ? 1.0 : p.size > 0 ? mu * p.pushes / p.size : 0.0;
  p.force = p.pushes * place.normal + held / shear * p.across;
  p.square = p.pushes * p.pushes + held * held * p.size * p.size;
  return p;
}

class Dual {
 public:
  Dual(const std::vector<CarryingPlace>& places, const Wrench& goal, const SpreadOptions& options,
       double penalty)
      : places_(places),
        goal_(goal),
        moments_(options.moments),
        shear_(options.shear),
        give_(1 / (penalty * penalty)) {}

  Projection at(const CarryingPlace& place, const Wrench& y) const {
    return project(place, shear_, ease(place) * (y.force + moments_ * cross(y.moment, place.arm)));
  }

  // The minimum along y, as a part of it: the dual is a quadratic on every ray from 0.
  double along(const Wrench& y) const {
    double sum = dot(y, y);
    for (const CarryingPlace& place : places_) sum += at(place, y).square / ease(place);
    return dot(y, goal_) / sum;
  }

  // The gradient's part along a way.
  double slope_along(const Wrench& y, const Wrench& way) const {
    double sum = dot(moved(y, -1, goal_), way);
    for (const CarryingPlace& place : places_) {
      const Projection p = at(place, y);
      sum += dot(p.force, way.force + moments_ * cross(way.moment, place.arm));
    }
    return sum;
  }

  // The gradient and a generalised Hessian (6, 6), of which the lower triangle is set.
  void expand(const Wrench& y, Wrench& slope, double* bend) const {
    std::fill(bend, bend + 36, 0.0);
    for (int i = 0; i < 6; i++) bend[6 * i + i] = 1;
    slope = moved(y, -1, goal_);
    for (const CarryingPlace& place : places_) {
      const Projection p = at(place, y);
      if (p.pushes <= 0) continue;
      slope.force += p.force;
      slope.moment += moments_ * cross(place.arm, p.force);
      add_bend(place, p, bend);
    }
  }

 private:
  // Adds ease L D L^T with L = (1, [moments arm]x) and D the derivative of the projection, as a sum
  // of squares of vectors: D = sum_k weight_k d_k d_k^T.
  void add_bend(const CarryingPlace& place, const Projection& p, double* bend) const {
    const double sheared = ease(place) / (shear_ * shear_);
    if (!p.slips) {
      for (int i = 0; i < 3; i++) {
        Vec3 axis;
        axis[i] = 1;
        add_square(place, axis, sheared, bend);
      }
      add_square(place, place.normal, ease(place) - sheared, bend);
      return;
    }
    const double mu = shear_ * place.friction;
    const Vec3 tangent = p.size > 0 ? (1 / p.size) * p.across : Vec3{};
    const Vec3 edge = place.normal + place.friction * tangent;
    add_square(place, edge, ease(place) / (1 + mu * mu), bend);
    if (p.size > 0)
      add_square(place, cross(place.normal, tangent), sheared * mu * p.pushes / p.size, bend);
  }

  void add_square(const CarryingPlace& place, Vec3 d, double weight, double* bend) const {
    const Vec3 turn = moments_ * cross(place.arm, d);
    const double v[6] = {d.x, d.y, d.z, turn.x, turn.y, turn.z};
    for (int i = 0; i < 6; i++)
      for (int j = 0; j <= i; j++) bend[6 * i + j] += weight * v[i] * v[j];
  }

  double ease(const CarryingPlace& place) const { return give_ * place.ready2; }

  const std::vector<CarryingPlace>& places_;
  Wrench goal_;
  double moments_, shear_, give_;
};

// -bend^-1 slope.
Wrench newton_step(double* bend, const Wrench& slope) {
  static const double least[6] = {};
  double x[6] = {-slope.force.x,  -slope.force.y,  -slope.force.z,
                 -slope.moment.x, -slope.moment.y, -slope.moment.z};
  factor_cholesky(bend, 6, least);
  solve_cholesky(bend, 6, x);
  return {load3(x), load3(x + 3)};
}

// The part of a Newton step at which the dual has become flat along it: its slope there is at most
// kSpreadFlat of that at the start. The slope rises along the step, so that false position brackets
// it; a whole step is good where the dual still descends. `start`: the slope at 0, negative.
double step_length(const Dual& dual, const Wrench& y, const Wrench& way, double start,
                   int searches) {
  const double flat = -tuning::support::kSpreadFlat * start;
  double low = 0, high = 1, at_low = start, at_high = dual.slope_along(moved(y, 1, way), way);
  if (at_high <= flat) return 1;
  for (int k = 0, side = 0; k < searches; k++) {
    const double length = low + (high - low) * at_low / (at_low - at_high);
    const double slope = dual.slope_along(moved(y, length, way), way);
    if (std::fabs(slope) <= flat) return length;
    // The end that stays twice counts half, or it would stay for good (Illinois).
    if (slope > 0) {
      high = length, at_high = slope;
      if (side == 1) at_low *= 0.5;
      side = 1;
    } else {
      low = length, at_low = slope;
      if (side == -1) at_high *= 0.5;
      side = -1;
    }
  }
  return low;
}

}  // namespace

void spread_wrench(const double* wrench, const std::vector<CarryingPlace>& places,
                   const SpreadOptions& options, std::vector<Vec3>& force) {
  force.assign(places.size(), Vec3{});
  const Wrench goal{load3(wrench), options.moments * load3(wrench + 3)};
  const double size2 = dot(goal, goal);
  if (size2 == 0 || places.empty()) return;
  Wrench y = goal, slope;
  double bend[36];
  for (size_t level = 0; level < options.penalties.size(); level++) {
    const bool last = level + 1 == options.penalties.size();
    const double tolerance = last ? options.tolerance : tuning::support::kSpreadCoarse;
    const Dual dual(places, goal, options, options.penalties[level]);
    y = moved({}, dual.along(y), y);
    for (int k = 0; k < options.steps; k++) {
      dual.expand(y, slope, bend);
      if (dot(slope, slope) <= tolerance * tolerance * size2) break;
      const Wrench way = newton_step(bend, slope);
      y = moved(y, step_length(dual, y, way, dot(slope, way), options.searches), way);
    }
    if (last)
      for (size_t i = 0; i < places.size(); i++) force[i] = dual.at(places[i], y).force;
  }
}

}  // namespace hp
