// The drive: which velocity the motion asks of a person's joints (docs/physics.md, "The drive").
//
// Free motion has no forces, so a velocity that the drive sets stays. With e = v - v_ref the
// deviation of velocity from the motion's own, xi how far a joint is from where the motion has it,
// h the substep:
//
//   time constant tau > 0    v* = v_ref + (e - h xi/tau^2)/s,  s = (1 + h/tau)^2,
//                            M^ = s (M + lambda diag(I))
//   tau = 0 (Algorithm 1)    v is set to log(q^-1 q_target)/dt once a frame; within it (PJSC)
//                            v* = v + M^^-1 (lambda I/h) (log(q^-1 q~) - h v),
//                            M^ = M + lambda diag(I)
//
// With Algorithm 1 a joint that was kept from its target returns to the motion no faster than
// `recovery_rate` + kReturnPerMotion |v_ref|, and limp joints (lambda < h/T, T = kLimpTime) are
// damped against that return, so that what the root feeds into them does not swing on:
//
//   v* = v + M^^-1 (lambda I/h) (log(q^-1 q~) - h v) - M^^-1 (h/T - lambda) I (v - v_drive),
//   M^ = M + (h/T) diag(I)
//
// (v_drive: the velocity that the frame begins with.) Neither acts in free motion, which stays exact.
//
// lambda is the firmness of each ball joint, I the mean of its diagonal entries of M [kg m^2], q~
// the pose without contact. A deviation decays like a critically damped spring, whatever the frame
// rate.
#pragma once
#include <vector>

#include "dynamics/joint_range.h"
#include "dynamics/inertia.h"
#include "footing/footing.h"
#include "stepping/drive_effort.h"
#include "stepping/gentle_return.h"
#include "stepping/person_dofs.h"
#include "stepping/reference_clock.h"
#include "stepping/reference_motion.h"

namespace hp {

struct DriveSettings {
  double time_constant = 0;   // tau [s]; 0: Algorithm 1 of the paper
  double recovery_rate = 8;   // most that a joint returns at [rad/s]
  bool recover_root = false;  // the root's position goes back to its path,
  double root_speed = 1;      // at this speed at most [m/s]
  // Baselines (baselines/internal_forces.h, baselines/torque_drive.cpp).
  bool internal_forces = false;
  double joint_damping = 0;     // [N m s/rad]
  double torque_frequency = 0;  // of PD torques in place of the joints' velocities [rad/s]; 0: none
  double torque_damping = 1;    // damping ratio of these
  bool own_forces() const { return internal_forces || joint_damping > 0; }
  bool torque() const { return torque_frequency > 0; }
  double torque_firmness(double h) const;
  // What a joint resists with in a substep of length h, in its own inertia: lambda, or more.
  double resistance(double lambda, double h) const;
};

// log(from^-1 to) of two rotations (wxyz), in the child's frame [rad].
inline Vec3 rotation_between(const double* from, const double* to) {
  return log_quat(conjugate(load4(from)) * load4(to));
}

// Most force on a root along the ground, up and down [N].
struct RootForce {
  bool on = false;
  bool falls = false;  // nothing holds it: what pulls it down acts on M, not on M^
  double across = 0, up = 0, down = 0;
  double upright(double force) const { return force > 0 ? up : down; }
};

class Drive : public PersonDofs {
 public:
  ReferenceMotion motion;
  ReferenceClock clock;
  Footing footing;
  GentleReturn gentle_return;
  DriveEffort effort;
  // Most that the drive may exert (strength.h): a force on the root [N], then a torque on every
  // ball in the model's order [N m]; infinite where nothing limits it. Empty: nowhere.
  std::vector<double> limits;
  // Ranges of every ball (joint_ranges.h), the root's ignored. Empty: joints have none.
  std::vector<JointRange> ranges;
  // Contacts of the last frame held it up.
  bool carried = false;
  // It sits or lies: skin but the feet's has been at rest on something, and contacts hold it up since.
  bool sits = false;
  // In their place the force on the root of somebody with a footing, by what it stands on.
  RootForce root_force;
  // How fast each ball comes back to the motion in this frame, at most [rad/s]. Empty: nothing is in the way.
  std::vector<double> yields;

  Drive(const Model& m, int root_body);

  // The body is put at `target` (qpos layout of the person) at rest.
  void reset(const double* target, double* qvel);
  // A frame of length dt towards `target` begins.
  void aim(const DriveSettings& s, const double* target, double dt, const double* qpos);
  // What becomes of the root in a frame that is about to be aimed at `target`, if nothing is in the way: how
  // it will be turned off the motion (in the world), and how far what is left of a push will carry it along
  // the ground, and up where soft layers carry it [m].
  struct Ahead {
    Quat turned;
    Vec3 drift;
  };
  Ahead ahead(const DriveSettings& s, const double* target, double dt, const double* qpos) const;
  // Is the person where the motion has it, but for the root's position, and at its velocity? Then
  // only contact can keep it from the target.
  bool settled(const DriveSettings& s, const double* qpos) const;
  // The frame was followed to its end; `exerts`: the drive carried something meanwhile.
  void followed(bool exerts = false);
  // The frame is stepped through instead: velocities; Algorithm 1 sets qvel here.
  void begin_frame(const DriveSettings& s, const double* qpos, double* qvel);
  // The velocity v* that substep k (of length h, from pose qpos) would have without contact, and
  // the deviation eps - h v that PJSC restores (Algorithm 1 with lambda > 0; zero at the root and
  // wherever the motion is free). True if any is not zero: then the caller adds
  // M^^-1 (lambda I / h) deviation.
  bool free_velocity(const DriveSettings& s, int k, double h, const double* qpos,
                     const double* qvel, double* v_free, double* deviation) const;
  // After the solve: keeps the deviation of velocity. `pushed`: per body, contacts have pushed it.
  void end_substep(const double* qvel, double h, const std::vector<char>& pushed);

  // Firmness lambda of every ball, in the model's order; the first is the root's and ignored.
  void set_stiffness(const double* lambda);
  const std::vector<double>& stiffness() const { return stiffness_; }
  // lambda times the mean of each joint's diagonal entries of M, into extra [nv of the model].
  void added_inertia(const DriveSettings& s, double h, const Inertia& inertia,
                     std::vector<double>& extra) const;
  double scale(const DriveSettings& s, double h) const;  // s of M^

  // v_ref + e: the velocity that the drive would leave alone, into v [nv of the model].
  void unhindered(double* v) const;
  // Change of the deviation e by a substep that ended with qvel.
  void deviation_change(const double* qvel, double* change) const;
  // v_ref, and how fast it changes: spread over the frame; 0 in the first one after a reset, which
  // starts from rest only as far as numbers go.
  void reference(double* v) const;
  void reference_change(double* a) const;
  // Has a contact pushed a body that this ball moves within the last kTouchedTime?
  bool lately(int ball) const { return lately_[ball] > 0; }
  bool lately() const;  // any of its bodies

  bool gentle() const { return gentle_return.active(); }

  // Everything that outlives a frame.
  void save(std::vector<double>& out) const;
  const double* load(const double* in);

 private:
  Vec3 keeps(const DriveSettings& s, Vec3 v_ref) const;
  void set_velocities(const DriveSettings& s, const double* q, double* qvel);
  void spring_velocity(const DriveSettings& s, int k, double h, const double* q, double* v) const;
  bool restored_deviation(const DriveSettings& s, int k, double h, const double* q, const double* v,
                          double* out) const;
  // The same of PD torques towards the target (baselines/torque_drive.cpp).
  bool torque_deviation(const DriveSettings& s, double h, const double* qpos, const double* qvel,
                        double* deviation) const;

  std::vector<double> v_ref_, deviation_;  // per dof of the person
  std::vector<double> q_start_, v_drive_;  // Algorithm 1: pose and velocity at the frame's start
  std::vector<double> gain_;               // reference_change() of this frame
  std::vector<double> stiffness_;          // per ball
  std::vector<double> lately_;             // per ball: how long it still counts as touched [s]
  bool exact_ = false;  // the pose is the target's, bit for bit, but for the root's position
};

}  // namespace hp
