#include "soft/soft_law.h"

namespace hp {

namespace {

double fourth(double d, double t) {
  const double x = t > 0 ? d / t : 0;
  return x * x * x * x;
}

}  // namespace

double SoftLaw::pressure(double d, double t) const {
  return d > 0 ? stiffness * d * (1 + densification * fourth(d, t)) : 0;
}

double SoftLaw::slope(double d, double t) const {
  return d > 0 ? stiffness * (1 + 5 * densification * fourth(d, t)) : 0;
}

double SoftLaw::energy(double d, double t) const {
  return d > 0 ? 0.5 * stiffness * d * d * (1 + densification * fourth(d, t) / 3) : 0;
}

double SoftLaw::energy_sum(double d, double t) const {
  return d > 0 ? stiffness * d * d * d / 6 * (1 + densification * fourth(d, t) / 7) : 0;
}

SoftLaw in_series(const SoftLaw& a, const SoftLaw& b) {
  if (a.stiffness <= 0) return b;
  if (b.stiffness <= 0) return a;
  SoftLaw s;
  s.stiffness = a.stiffness * b.stiffness / (a.stiffness + b.stiffness);
  // The layer that is without damping gives way at once.
  const double c = a.damping + b.damping;
  s.damping = c > 0 ? a.damping * b.damping / c : 0;
  // What stiffens and remembers does so by its share of the depth.
  const double share = s.stiffness / a.stiffness, rest = 1 - share;
  s.densification = share * a.densification + rest * b.densification;
  s.arm = share * a.arm + rest * b.arm;
  s.relaxation = a.arm >= b.arm ? a.relaxation : b.relaxation;
  return s;
}

}  // namespace hp
