// The reference motion of a person within a frame: from the last target pose to the next one.
//
// The root's position goes along a straight line, joints turn at constant rates in the child's
// frame: q(t) = q_0 exp(t w), w = log(q_0^-1 q_1)/dt [rad/s]. With root recovery the root's
// velocity gets a share of the way back to the path, of time constant 0.3 s.
#pragma once
#include <vector>

#include "stepping/person_dofs.h"

namespace hp {

struct DriveSettings;

class ReferenceMotion {
 public:
  explicit ReferenceMotion(const PersonDofs& dofs)
      : dofs_(dofs), target_(dofs.qpos_count()), previous_(dofs.qpos_count()) {}

  // Share of its pace at which the root goes back to its path along the ground: who waits stays.
  double eager = 1;

  // It goes along the ground with a velocity of its own [m/s], and not with the motion: round something.
  bool goes_round = false;
  Vec3 goes;

  // The person is put at `target` (its qpos) at rest.
  void reset(const double* target);
  // A frame of length dt [s] towards `target` begins, from the pose `qpos` of the model.
  // With `weight` its height comes back to the motion's even if the root does not.
  void aim(const DriveSettings& s, const double* target, double dt, const double* qpos,
           bool weight = false);
  // The path goes on so much higher [m].
  void raise(double by) { target_[2] += by; }
  // A ball, by its place in the person's qpos, goes on from rotation `q` (wxyz), where it is.
  void go_on(int ball_qpos, const double* q) { std::copy_n(q, 4, &target_[ball_qpos]); }
  // The root's velocity in this frame, and in the one before, but for the motion's own: back to the path, or
  // round something [m/s].
  Vec3 beside() const { return beside_; }
  Vec3 beside_before() const { return beside_before_; }
  // How far the root will be off its path along the ground at the end of a frame that is about to be
  // aimed at `next`, if nothing is in the way, and how far above it is now [m].
  Vec3 displaced(const DriveSettings& s, const double* next, double dt, const double* qpos) const;
  // The person follows the frame to its end: its velocity is that of the motion.
  void follow_all() { velocity_known_ = false; }
  // A frame is stepped through: velocities of a frame before that was followed have been asked for.
  void step_through() { older_asked_ = true; }

  // The pose at a share of the frame (1: its end) of a person whose root is at qpos at its start.
  void follow(double share, double* qpos) const;
  // The pose at a share of the frame as the motion has it, root position included, whatever
  // happens.
  void put(double share, double* qpos) const;
  // The velocity of a person who followed, into qvel of the model; nothing where it was stepped
  // through.
  void velocity(double* qvel) const;
  // The velocity of the motion in this frame, per dof of the person.
  void reference(double* v) const;
  // The rotation of a ball at a share of the frame.
  Quat at(const PersonDofs::Ball& b, double share) const;
  // Upper bound of the angular speed of each ball while following [rad/s], the root first.
  void speeds(std::vector<double>& angular) const;

  const std::vector<double>& target() const { return target_; }  // qpos at the end of the frame
  Quat before(const PersonDofs::Ball& b) const { return load4(&previous_[b.qpos]); }
  Quat after(const PersonDofs::Ball& b) const { return load4(&target_[b.qpos]); }
  Vec3 root_velocity() const { return root_velocity_; }
  double frame_length() const { return dt_; }  // [s]
  bool fresh() const { return fresh_; }        // nothing has been aimed at since the reset
  bool first() const { return first_; }        // nor before this frame

  // Of a saved target, and beside().
  void restore(const double* target, bool fresh, Vec3 beside);

 private:
  Vec3 beside(const DriveSettings& s, const std::vector<double>& reached, const double* next,
              double dt, const double* qpos, bool weight) const;
  void difference(const std::vector<double>& from, const std::vector<double>& to, double dt,
                  Vec3 root, double* v) const;

  PersonDofs dofs_;
  std::vector<double> target_, previous_;  // qpos of the person
  double dt_ = 0;
  Vec3 root_velocity_, beside_, beside_before_;  // [m/s]
  bool fresh_ = true, first_ = true;
  bool velocity_known_ = true;  // it is in qvel
  // Of the frame before, while its velocity has not been asked for.
  std::vector<double> older_;
  double older_dt_ = 0;
  Vec3 older_root_;
  bool older_asked_ = true;
};

}  // namespace hp
