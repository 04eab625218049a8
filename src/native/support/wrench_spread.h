// The wrench that a person needs, spread over the places of the skin that can carry.
//
// For one frame, with the wrench w (force and moment), places at r_i from the point of the moments,
// each with a readiness b_i, e_i = (b_i / penalty)^2, and the friction cone K_i = {|f_t| <= mu f_n}:
//
//     minimise  1/2 |S (sum_i J_i f_i - w)|^2 + 1/2 sum_i |f_i|^2 / e_i,   f_i in K_i
//     J_i f = (f, r_i x f),   S: forces times 1, moments times `moments`
//
// where |f|^2 has the tangential part of f times `shear`.
//
// The dual has six unknowns, the scaled wrench y that is missing. With g_i = e_i J_i^T S y every
// force is the projection of g_i on K_i, and y is the minimum of
//
//     1/2 |y|^2 - y . S w + 1/2 sum_i |proj_i(g_i)|^2 / e_i,
//
// strongly convex with a continuous gradient. Newton steps, each shortened to where the dual is flat
// along it, find it; their number is bounded. A larger penalty has fewer kinks: its minimum is where the
// search for the next smaller one starts. halfphysics/support/wrench_qp.py chooses the constants;
// tests/support/references/wrench_qp.py is the same in numpy.
#pragma once
#include <cstddef>
#include <vector>

#include "math/vec.h"

namespace hp {

// A place that can carry: from the point of the moments [m], its unit normal, its coefficient of
// friction, and its readiness squared.
struct CarryingPlace {
  Vec3 arm, normal;
  double friction, ready2;
};

// Constants of the problem: penalties, falling, of which the last counts; the weight of moments
// [1/m] and of tangential forces; the part of |S w| under which the gradient counts as 0; the most Newton steps at a penalty
// and searches along a step.
struct SpreadOptions {
  std::vector<double> penalties;
  double moments, shear, tolerance;
  int steps, searches;
};

// Forces (n) at the places [N] that come closest to a wrench (6).
void spread_wrench(const double* wrench, const std::vector<CarryingPlace>& places,
                   const SpreadOptions& options, std::vector<Vec3>& force);

}  // namespace hp
