#include "dynamics/joint_range.h"

#include <algorithm>
#include <cmath>
#include <stdexcept>

#include "tuning.h"

namespace hp {

namespace tune = tuning::dynamics;

namespace {

// q in the frame of a range: w >= 0, and the swing's components.
struct SwingTwist {
  double w, t, f, a;  // q
  double N;           // w of the swing
  double sf, sa;      // v of the swing

  SwingTwist(const JointRange& r, Quat q) {
    const double sign = q.w < 0 ? -1 : 1;
    const Vec3 v = sign * Vec3{q.x, q.y, q.z};
    w = sign * q.w, t = dot(v, r.axis[0]), f = dot(v, r.axis[1]), a = dot(v, r.axis[2]);
    N = std::sqrt(w * w + t * t);
    // A swing by 180 degrees has any twist: none.
    const double c = N > 0 ? w / N : 1, s = N > 0 ? t / N : 0;
    sf = c * f - s * a, sa = c * a + s * f;
  }
};

}  // namespace

void JointRange::finish() {
  for (int i = 0; i < 3; i++) {
    const Vec3 &x = axis[i], &y = axis[(i + 1) % 3], &z = axis[(i + 2) % 3];
    // What is no number is no frame either.
    if (!(norm(cross(x, y) - z) <= tune::kFrameRounding &&
          std::fabs(norm(x) - 1) <= tune::kFrameRounding))
      throw std::invalid_argument("a joint's axes must be orthonormal and right-handed");
    if (!(lower[i] <= 0 && upper[i] >= 0 && lower[i] >= -M_PI && upper[i] <= M_PI))
      throw std::invalid_argument("a joint's range must be within [-pi, pi] and hold 0");
    quarter_low[i] = elementary::tan(0.25 * lower[i]),
    quarter_up[i] = elementary::tan(0.25 * upper[i]);
  }
}

bool JointRange::holds(Quat q) const {
  const SwingTwist p(*this, q);
  const double values[3] = {p.t, p.sf, p.sa}, scales[3] = {p.N + p.w, 1 + p.N, 1 + p.N};
  for (int i = 0; i < 3; i++)
    if (values[i] < quarter_low[i] * scales[i] || values[i] > quarter_up[i] * scales[i])
      return false;
  return true;
}

Vec3 joint_angles(const JointRange& r, Quat q) {
  const SwingTwist p(r, q);
  return {2 * elementary::atan2(p.t, p.w), 4 * elementary::atan(p.sf / (1 + p.N)),
          4 * elementary::atan(p.sa / (1 + p.N))};
}

Quat from_joint_angles(const JointRange& r, Vec3 angles) {
  const double f = elementary::tan(0.25 * angles.y), a = elementary::tan(0.25 * angles.z);
  const double scale = 1 / (1 + f * f + a * a);
  const Vec3 side = (2 * scale * f) * r.axis[1] + (2 * scale * a) * r.axis[2];
  const Quat swing{2 * scale - 1, side.x, side.y, side.z};
  const Vec3 turn = elementary::sin(0.5 * angles.x) * r.axis[0];
  return swing * Quat{elementary::cos(0.5 * angles.x), turn.x, turn.y, turn.z};
}

Vec3 clamped_angles(const JointRange& r, Quat q, Quat asked) {
  Vec3 out = joint_angles(r, q);
  const Vec3 own = joint_angles(r, asked);
  for (int i = 0; i < 3; i++)
    out[i] = std::clamp(out[i], std::min(r.lower[i], own[i]), std::max(r.upper[i], own[i]));
  return out;
}

bool has_twist(const JointRange& r, Quat q) { return SwingTwist(r, q).N > tune::kLeastTwistShare; }

void joint_angle_rates(const JointRange& r, Quat q, Vec3 out[3]) {
  const SwingTwist p(r, q);
  const double N = std::max(p.N, tune::kLeastTwistShare), c = p.w / N, s = p.t / N;
  const double y[2] = {p.sf / (1 + N), p.sa / (1 + N)};
  for (int i = 0; i < 3; i++) out[i] = {};
  for (int k = 0; k < 3; k++) {  // omega along axis k
    const double wt = k == 0, wf = k == 1, wa = k == 2;
    const double dw = -0.5 * (p.t * wt + p.f * wf + p.a * wa);
    const double dt = 0.5 * (p.w * wt + p.f * wa - p.a * wf);
    const double df = 0.5 * (p.w * wf + p.a * wt - p.t * wa);
    const double da = 0.5 * (p.w * wa + p.t * wf - p.f * wt);
    const double dphi = 2 * (p.w * dt - p.t * dw) / (N * N), dN = (p.w * dw + p.t * dt) / N;
    const double dc = -0.5 * s * dphi, ds = 0.5 * c * dphi;
    const double dsf = dc * p.f + c * df - ds * p.a - s * da;
    const double dsa = dc * p.a + c * da + ds * p.f + s * df;
    const double dy[2] = {(dsf - y[0] * dN) / (1 + N), (dsa - y[1] * dN) / (1 + N)};
    out[0] += dphi * r.axis[k];
    for (int i = 0; i < 2; i++) out[i + 1] += (4 * dy[i] / (1 + y[i] * y[i])) * r.axis[k];
  }
}

}  // namespace hp
