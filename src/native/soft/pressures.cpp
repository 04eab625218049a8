#include "soft/pressures.h"

#include <algorithm>
#include <cmath>

#include "soft/sample_lanes.h"
#include "tuning.h"

namespace hp {

namespace tune = tuning::soft;

namespace {

using N = NearSamples;

HP_INLINE Lanes clamped(const Lanes& x) {
  const Lanes zero = {}, one = zero + 1.0;
  const Lanes up = x < zero ? zero : x;
  return up > one ? one : up;
}

HP_INLINE void face(const SampleLanes& at) {
  const Lanes zero = {}, one = zero + 1.0, least = zero + tune::kLeastEdge;
  const Lanes along = at(N::Normal, 0) * at(N::Away, 0) + at(N::Normal, 1) * at(N::Away, 1) +
                      at(N::Normal, 2) * at(N::Away, 2);
  const Lanes cosine = clamped(-along);
  at(N::Depth) = at(N::LayerThickness) + at(N::Own) * cosine - at(N::Distance);
  // Half of the depths' spread over the piece of surface that a sample stands for.
  const Lanes rest = one - cosine * cosine;
  const Lanes spread = at(N::HalfWidth) * square_root(rest > zero ? rest : zero);
  const Lanes edge = spread > least ? spread : least;
  at(N::Edge) = edge;
  // What is askew is pressed in by less, of foam that is no thinner; nor than its depths spread.
  const Lanes thick = at(N::LayerThickness) + at(N::Own);
  at(N::Thickness) = thick > edge ? thick : edge;
  at(N::Area) = at(N::Surface) * cosine;
}

HP_INLINE void start_step(const SampleLanes& at) {
  for (int k = 0; k < 3; k++) at(N::First, k) = at(N::Hard, k) + at(N::Own) * at(N::Normal, k);
  at(N::Room) = at(N::Distance) - at(N::LayerThickness) - at(N::Own) - at(N::Slack);
  face(at);
  at(N::Before) = at(N::Depth);
}

HP_INLINE void go_on(double h, Vec3 v, Vec3 w, const SampleLanes& at) {
  const Lanes x = at(N::First, 0), y = at(N::First, 1), z = at(N::First, 2);
  const Lanes speed = at(N::Away, 0) * (v.x + (w.y * z - w.z * y)) +
                      at(N::Away, 1) * (v.y + (w.z * x - w.x * z)) +
                      at(N::Away, 2) * (v.z + (w.x * y - w.y * x));
  at(N::Depth) = at(N::Before) - h * speed;
}

// Means over the depths d - e to d + e of the springs' pressure and of its slope; what is not pressed has
// depth 0.
struct Springs4 {
  Lanes pressure, energy;
};
HP_INLINE void springs(const Lanes& d, const Lanes& by_thickness, const SampleLanes& at,
                       Springs4& out) {
  const Lanes zero = {};
  const Lanes in = d > zero ? d : zero;
  const Lanes x = in * by_thickness, kd = at(N::Stiffness) * in;
  const Lanes more = at(N::Densification) * (x * x) * (x * x);
  out.pressure = kd * (1.0 + more);
  out.energy = 0.5 * kd * in * (1.0 + more * (1.0 / 3));
}

HP_INLINE void press_to_end(double h, const SampleLanes& at) {
  const Lanes zero = {}, one = zero + 1.0;
  const Lanes d = at(N::Depth), before = at(N::Before), e = at(N::Edge);
  const Lanes whole = one / (2.0 * e), by_thickness = one / at(N::Thickness);
  const Lanes share = clamped((d + e) * whole);
  const Lanes arm = at(N::Arm) * at(N::Stiffness) * at(N::Relaxation) / (at(N::Relaxation) + h);
  Springs4 a, b;
  springs(d + e, by_thickness, at, a);
  springs(d - e, by_thickness, at, b);
  const Lanes own = share * arm * (d - at(N::Gone));
  const Lanes flow = share * at(N::Damping) * (1 / h);
  const Lanes pressure = (a.energy - b.energy) * whole + flow * (d - before) + own;
  const Lanes slope = (a.pressure - b.pressure) * whole + flow + share * arm;
  const Lanes deepest = d > before ? d : before;
  const Lanes there = at(N::Area) > zero ? deepest + e : zero;
  const Lanes pushes = there > zero ? pressure : zero;
  at(N::Pressure) = pushes > zero ? pushes : zero;
  at(N::Slope) = pushes > zero ? slope : zero;
  at(N::ArmPressure) = there > zero ? own : zero;
  at(N::Pressed) = there > zero ? share : zero;
}

}  // namespace

HP_CLONES void start_step(NearSamples& near) {
  for (int i = 0; i < near.size(); i += kLanes) start_step({near, i});
}

HP_CLONES void face(NearSamples& near) {
  for (int i = 0; i < near.size(); i += kLanes) face({near, i});
}

HP_CLONES void go_on(double h, Vec3 v, Vec3 w, NearSamples& near) {
  for (int i = 0; i < near.size(); i += kLanes) go_on(h, v, w, {near, i});
}

HP_CLONES void press_to_end(double h, NearSamples& near) {
  for (int i = 0; i < near.size(); i += kLanes) press_to_end(h, {near, i});
}

HP_CLONES void find_went(double h, NearSamples& near) {
  const Lanes zero = {};
  for (int i = 0; i < near.size(); i += kLanes) {
    const SampleLanes at{near, i};
    const Lanes firmness = at(N::Relaxation) * (at(N::Arm) * at(N::Stiffness) * at(N::Pressed));
    const Lanes goes = at(N::Pressure) > zero ? firmness : zero;
    at(N::Went) = goes > zero ? h * at(N::ArmPressure) / firmness : zero;
  }
}

namespace {

// Means over the depths d - e to d + e of the springs' pressure, of its slope, and of their energy.
struct Spread {
  SoftLaw law;
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

}  // namespace

void press_by_mean(double h, NearSamples& near) {
  for (int i = 0; i < near.size(); i++) {
    double &pressure = near[N::Pressure][i], &slope = near[N::Slope][i];
    double &own = near[N::ArmPressure][i], &share = near[N::Pressed][i];
    const double depth = near[N::Depth][i], before = near[N::Before][i], e = near[N::Edge][i];
    pressure = slope = own = share = 0;
    if (near[N::Area][i] <= 0 || std::max(depth, before) <= -e) continue;
    const Spread at{near.law(i), near[N::Thickness][i], e};
    const SoftLaw& law = at.law;
    const double way = depth - before, middle = before + 0.5 * way;
    share = at.share(middle);
    const double arm = law.arm * law.stiffness / (1 + 0.5 * h / law.relaxation);
    if (std::fabs(way) > tune::kNoIndent) {
      pressure = (at.energy(depth) - at.energy(before)) / way;
      slope = (at.mean(depth).pressure - pressure) / way;
    } else {
      const Spread::Mean springs = at.mean(middle);
      pressure = springs.pressure;
      slope = 0.5 * springs.slope;
    }
    own = share * arm * (middle - near[N::Gone][i]);
    pressure += share * law.damping * way / h + own;
    slope += share * (law.damping / h + 0.5 * arm);
    if (!(pressure > 0)) pressure = slope = 0;
  }
}

namespace {

// The energy [J] at its depth, where the dashpot of the Maxwell arm has gone q [m].
double stored(double q, const NearSamples& near, int i) {
  const double depth = near[N::Depth][i], e = near[N::Edge][i], area = near[N::Area][i];
  if (area <= 0 || depth <= -e) return 0;
  const Spread at{near.law(i), near[N::Thickness][i], e};
  const double arm = depth - q;  // foam that comes back slowly pulls on its springs
  return area *
         (at.energy(depth) + 0.5 * at.share(depth) * at.law.arm * at.law.stiffness * arm * arm);
}

}  // namespace

void store(NearSamples& near) {
  for (int i = 0; i < near.size(); i++) near[N::Stored][i] = stored(near[N::Gone][i], near, i);
}

double given_back(double h, const NearSamples& near) {
  double sum = 0;
  for (int i = 0; i < near.size(); i++) {
    if (!(near[N::Pressure][i] > 0)) continue;  // what does not push gives and takes nothing
    const double went = near[N::Went][i], way = near[N::Depth][i] - near[N::Before][i];
    const double springs = near[N::Stored][i] - stored(near[N::Gone][i] + went, near, i);
    const double damper = near[N::Pressed][i] * near[N::Damping][i] * way * way / h;
    sum += springs - near[N::Area][i] * (damper + near[N::ArmPressure][i] * went);
  }
  return sum;
}

}  // namespace hp
