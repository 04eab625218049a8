// How a soft layer answers pressing: pressure by depth, for each unit of area (a Winkler foundation).
//
// With the depth d [m] that the surface is pressed in, its rate d' [m/s], the layer's thickness t [m] and
// x = d/t, the pressure [Pa] is p = max(0, p_s(d) + c d' + p_m):
//
//     p_s(d) = k d (1 + D x^4)             springs, stiffening towards full compression; linear: D = 0
//     p_m    = r k (d - q)                 one Maxwell arm: a spring r k in series with a dashpot,
//     q'     = (d - q)/tau                 which has gone q: hysteresis
//
// What has been left goes back by q' = -q/(tau (1 + r)): the surface without load stays r q/(1 + r)
// below where it was, and comes back slowly. Pressure never pulls.
//
// The springs' energy for each unit of area is Psi(d) = k d^2/2 (1 + D x^4/3) [J/m^2].
//
// Two layers that press each other (soft skin on a sofa) are springs in series: 1/k = 1/k1 + 1/k2, the
// thicknesses add up, and so do 1/c.
#pragma once

namespace hp {

struct Springs {
  double pressure = 0, energy = 0;  // p_s [Pa], Psi [J/m^2]
};

struct SoftLaw {
  double stiffness = 0;      // k [Pa/m]
  double damping = 0;        // c [Pa s/m]
  double densification = 0;  // D
  double arm = 0;            // r
  double relaxation = 1;     // tau [s]

  // p_s [Pa] and its derivative [Pa/m], and Psi [J/m^2], at depth d of a layer of thickness t [m]; 0
  // where d <= 0.
  double pressure(double d, double t) const;
  double slope(double d, double t) const;
  double energy(double d, double t) const;
  // Both at once.
  Springs springs(double d, double t) const {
    if (d <= 0) return {};
    const double x = d / t, kd = stiffness * d, more = densification * (x * x) * (x * x);
    return {kd * (1 + more), 0.5 * kd * d * (1 + more / 3)};
  }
  // The integral of the energy over the depth [J/m].
  double energy_sum(double d, double t) const;
};

// Two layers one on the other; a stiffness of 0 is a hard one.
SoftLaw in_series(const SoftLaw& a, const SoftLaw& b);

}  // namespace hp
