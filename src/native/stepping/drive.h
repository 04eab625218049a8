// The drive: which velocity the motion asks of a person's joints (METHOD: "The drive").
#pragma once
#include <vector>

#include "dynamics/kinematic_tree.h"

namespace hp {

struct DriveSettings {
  double time_constant = 0;  // tau [s]; 0: Algorithm 1 of the paper
  double recovery_rate = 8;  // w_max [rad/s]
  bool recover_root = false;
  double root_speed = 1;     // v_max [m/s]
  // Baselines (baselines/internal_forces.h, baselines/torque_drive.cpp).
  bool internal_forces = false;
  double joint_damping = 0;     // [N m s/rad]
  double torque_frequency = 0;  // of PD torques in place of the joints' velocities [rad/s]; 0: none
  double torque_damping = 1;
  bool own_forces() const { return internal_forces || joint_damping > 0; }
  bool torque() const { return torque_frequency > 0; }
  double torque_firmness(double h) const;
};

// One person: a free root and ball joints, contiguous in the model.
class Drive {
 public:
  Drive(const Model& m, int root_body);

  int first_qpos() const { return qpos0_; }
  int first_dof() const { return dof0_; }
  int qpos_count() const { return nq_; }
  int dof_count() const { return nv_; }

  // The body is put at `target` (qpos layout of the person) at rest.
  void reset(const double* target, double* qvel);
  // Start of a frame of length dt towards `target`.
  void aim(const DriveSettings& s, const double* target, double dt, const double* qpos);
  // Is the person where the motion has it, but for the root's position, and at its velocity? Then
  // nothing but contact can keep it from the target.
  bool settled(const DriveSettings& s, const double* qpos) const;
  // The pose at the end of the frame (share 1), or before it, of who is settled and meets nothing;
  // `qpos` is the pose at its start.
  void follow(double share, double* qpos) const;
  // The pose at a share of the frame as the motion has it, root position included, whatever happens.
  void put(double share, double* qpos) const;
  // The frame was followed to its end; `exerts`: the drive carried something meanwhile.
  void followed(bool exerts = false);
  // The frame is stepped through instead: velocities; Algorithm 1 sets qvel here.
  void begin_frame(const DriveSettings& s, const double* qpos, double* qvel);
  // Whoever followed a frame has the motion's velocity.
  void velocity(double* qvel) const;
  // Upper bound of each joint's angular speed while following [rad/s], per ball joint: the root
  // first; and the root's velocity.
  void speeds(std::vector<double>& angular, Vec3& root) const;
  int body(int ball) const { return balls_[ball].body; }
  // Velocity v* that substep k (of length h, from pose qpos) would have without contact, and
  // the deviation eps - h v that PJSC restores (Algorithm 1 with lambda > 0; zero at the root
  // and wherever the motion is free). True if any is not zero: then the caller adds
  // M^-1 (lambda I / h) deviation.
  bool free_velocity(const DriveSettings& s, int k, double h, const double* qpos,
                     const double* qvel, double* v_free, double* deviation) const;
  // The same of PD torques towards the target (baselines/torque_drive.cpp).
  bool torque_deviation(const DriveSettings& s, double h, const double* qpos, const double* qvel,
                        double* deviation) const;
  // Firmness lambda of every ball joint, in the model's order; the first is the root's and ignored.
  void set_stiffness(const double* lambda);
  const std::vector<double>& stiffness() const { return stiffness_; }
  int ball_count() const { return (int)balls_.size(); }
  int ball_dof(int ball) const { return dof0_ + balls_[ball].dof; }
  // The first of three dofs that a limit is of: 0 the root's position, i + 1 ball i.
  int limit_dof(int limit) const { return limit == 0 ? dof0_ : ball_dof(limit - 1); }
  // lambda * mean of each joint's diagonal entries of M, into extra[nv of the model].
  void added_inertia(const DriveSettings& s, double h, const Model& m, const Inertia& inertia,
                     std::vector<double>& extra) const;
  double scale(const DriveSettings& s, double h) const;

  // Most that the drive may exert (strength.cpp): a force on the root [N], then a torque on every ball
  // joint in the model's order [N m]; infinite where nothing limits it. Empty: nowhere.
  std::vector<double> limits;
  // What contacts made of v_free in a substep: the drive's own generalised impulse is M (change of
  // the deviation of velocity) - (contacts' impulses). `change` and `impulse`: nv of the model.
  void deviation_change(const double* qvel, double* change) const;
  void exert(const double* impulse);
  // v_ref + e: the velocity that the drive would leave alone, into v[nv of the model].
  void unhindered(double* v) const;
  // The drive's mean generalised force over the frame, per dof of the person, root first; empty if
  // it exerted none.
  std::vector<double> force() const;
  bool exerts() const { return exerted_; }
  // After the solve: keeps the deviation of velocity.
  void end_substep(const double* qvel, double h, const std::vector<char>& pushed);
  // Has anything pushed what this joint moves (`pushed`, per body) within the last kLately?
  bool lately(int ball) const { return lately_[ball] > 0; }
  // Root offset from the reference at the last target [m].
  const std::vector<double>& target() const { return target_; }

  // Goes back to the motion gently, so that no point goes faster than `speed` on any joint's account;
  // `reach` says (per body) how far from a joint any point that it moves is.
  void go_gently(double speed, const std::vector<double>& reach);
  bool gentle() const { return gentle_left_ > 0; }
  // A frame of length dt has passed: gentle as long as the person comes out of something, and then until
  // it is back at the motion's pose, but for the root's position, or for a while.
  void stay_gentle(bool comes_out, double dt, const double* qpos);
  double frame_length() const { return dt_; }  // of the last aim() [s]
  // The motion's own velocity, and how fast it changes: spread over the frame; 0 in the first one after
  // a reset, which starts from rest only as far as numbers go.
  void reference(double* v) const;
  void reference_change(double* a) const;

  // Everything that outlives a frame.
  void save(std::vector<double>& out) const;
  const double* load(const double* in);

 private:
  struct Ball {
    int qpos, dof;  // relative to the person's first
    int body;
  };
  int qpos0_, dof0_, nq_, nv_;
  std::vector<Ball> balls_;  // the root's rotation first
  std::vector<double> target_, previous_;   // qpos layout
  std::vector<double> v_ref_, deviation_;   // dof layout
  std::vector<double> q_start_, v_drive_;   // Algorithm 1: pose and velocity at the frame's start
  double dt_ = 0;
  std::vector<double> stiffness_;  // per ball
  std::vector<double> impulse_;    // of this frame, dof layout
  std::vector<double> gain_;       // reference_change() of this frame
  bool exerted_ = false;
  bool fresh_ = true, first_ = true;  // nothing has been aimed at since the reset; nor before this frame
  Vec3 root_velocity_;
  double gentle_left_ = 0;  // [s]
  std::vector<double> lately_;  // per ball [s]
  std::vector<double> gentle_rate_;  // per ball [rad/s]
  bool exact_ = false;  // the pose is the target's, bit for bit, but for the root's position
  bool velocity_known_ = true;
  // Of the frame before, while its velocity has not been asked for.
  std::vector<double> older_;
  double older_dt_ = 0;
  Vec3 older_root_;
  bool older_asked_ = true;

  void velocity(const std::vector<double>& from, const std::vector<double>& to, double dt,
                Vec3 root, double* qvel) const;
};

}  // namespace hp
