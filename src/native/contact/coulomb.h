// One Coulomb contact on its own, solved exactly.
//
// With p the impulse [N s] and w = r + A p the relative velocity [m/s] of the contact, each (n, t, s),
// A its 3 x 3 block of the Delassus operator [1/kg] and r what all other contacts leave it, the answer
// obeys
//     0 <= p_n,  w_n >= 0,  p_n w_n = 0,  |p_t| <= mu p_n,  and where it slips p_t = -mu p_n w_t/|w_t|.
// There are three cases:
//     it lifts off   r_n >= 0: p = 0;
//     it sticks      p = -A^-1 r, where that lies in the cone |p_t| <= mu p_n;
//     it slips       p = p_n (1, mu d) with a unit vector d = (c, s). From w_n = 0
//                        p_n = -r_n / N(d),   N(d) = A_nn + mu (A_nt c + A_ns s),
//                    and d must be parallel to the slip, against it: f(d) = d x (N w_t) = 0.
// f is a smooth function of the angle of d. Newton's method from the direction of the last answer
// usually finds its root. Near jamming (the normal gives way to friction, N near 0) several roots may
// lie close together; then all are isolated, as those of a polynomial of degree 4 in the tangent of
// half the angle, and the one with the smallest impulse is taken.
#pragma once
#include <cmath>

#include "math/vec.h"

namespace hp {

struct LocalContact {
  Mat3 A, inverse;
  double mu = 0;
  double tangent_step = 0;  // 1 / largest eigenvalue of the tangential block

  void set(const Mat3& a, double friction);
  // The answer to r; `old` only says where to look first for the direction of slip.
  Vec3 solve(Vec3 r, Vec3 old) const;
  // How far p is from its answer, as a velocity: normal, friction, and the larger of the two.
  double normal_residual(const double* p, const double* w) const {
    return std::fabs(std::min(w[0], p[0] * A.m[0]));
  }
  double friction_residual(const double* p, const double* w) const;
  double residual(const double* p, const double* w) const {
    return std::max(normal_residual(p, w), friction_residual(p, w));
  }
  double squared_residual(const double* p, const double* w) const;

 private:
  struct Slip {
    double f, slope;  // zero where slip and friction are parallel; derivative by the angle
    double normal;    // what one unit of p_n sliding this way gives the normal velocity
    double along;     // of the slip along the friction: negative where friction opposes it
  };
  Slip slip(Vec3 r, double c, double s) const;
  bool search(Vec3 r, double rounding, double& c, double& s) const;
};

// Friction back onto its disc.
inline void clamp_friction(double* p, double mu) {
  double length = std::sqrt(p[1] * p[1] + p[2] * p[2]), limit = mu * p[0];
  if (length <= limit) return;
  double f = limit > 0 ? limit / length : 0;
  p[1] *= f, p[2] *= f;
}

}  // namespace hp
