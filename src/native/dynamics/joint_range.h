// Ranges of ball joints: three angles of a joint's rotation, each with two ends.
//
// A rotation q is a twist about the bone, then a swing that turns the bone (swing * twist):
//   twist       phi = 2 atan2(v.t, w)
//   swing       two angles 4 atan(s.f / (1 + N)), 4 atan(s.a / (1 + N)) of the swing (N, s), N =
//               sqrt(w^2 + (v.t)^2): the quarter tangent of its rotation vector, by component
// t, f, a (axis[0..2]): twist, flexion and abduction, an orthonormal right-handed frame that is the same in
// parent and child at rest. A turn about one of them alone is that angle. The swing is regular up to a whole
// turn; the twist is not where the bone points back (swing 180 degrees), see kLeastTwistShare.
#pragma once
#include "math/vec.h"

namespace hp {

struct JointRange {
  Vec3 axis[3];                          // twist, flexion, abduction
  double lower[3], upper[3];             // of the three angles [rad]
  double quarter_low[3], quarter_up[3];  // tan of a quarter of them

  // Throws std::invalid_argument unless the axes are orthonormal and right-handed and the ends in order.
  void finish();
  // Are all angles of q within their ranges?
  bool holds(Quat q) const;
};

// The three angles of q [rad]; the twist is in (-pi, pi].
Vec3 joint_angles(const JointRange& r, Quat q);
// Their rates by the joint's angular velocity in the child's frame: rate of angle i = out[i] . omega.
void joint_angle_rates(const JointRange& r, Quat q, Vec3 out[3]);
// The rotation with these angles.
Quat from_joint_angles(const JointRange& r, Vec3 angles);
// The angles of q, each put within its range or, where `asked` is farther out, within what that has.
Vec3 clamped_angles(const JointRange& r, Quat q, Quat asked);
// Is the twist of q well defined?
bool has_twist(const JointRange& r, Quat q);

}  // namespace hp
