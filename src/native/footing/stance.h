// Stance: the pose of a reference as the body has it, and what of it rests.
//
// Somebody whom contacts have turned stands there: the reference is seen turned about the vertical like the
// body (kin), so that feet stay level; its hips are those of the body as it is tilted (body). What rests is
// read from the reference itself: points that are slow, in the world's time, and low. Who waits rests on
// both feet, turned level.
#pragma once
#include <vector>

#include "footing/flight.h"
#include "footing/footing_model.h"
#include "footing/footwork.h"

namespace hp {

// 1 up to `low`, 0 from `high` on.
inline double fades(double x, double low, double high) {
  return std::clamp((high - x) / (high - low), 0.0, 1.0);
}

class Stance {
 public:
  // Of one foot.
  struct Foot {
    double low = 0;      // 1: no part of the person is lower
    double high = 0;     // its lowest point, above the person's [m]
    double rests = 0;    // 0: it moves, 1: it rests
    double rested = 0;   // for how long it has, more or less [s]
    bool held = false;   // it rests because the person waits
    bool turns = false;  // it is turned from how the reference has it
    Quat turn;           // by this, in the world
  };
  // How the reference is seen in a frame.
  struct View {
    double dt = 0, passed = 0;  // of time, and of the reference's own [s]
    double gravity = 0;         // [m/s^2]
    Quat turned;                // the body off the motion, in the world
    double waits = 0;           // 0: time passes as it does, 1: it stands
  };

  Kinematics kin;             // of the reference, turned about the vertical like the body
  std::vector<Vec3> points;   // soles, then skin, of `kin` [m]
  std::vector<double> speed;  // of these in the reference [m/s]
  std::vector<double> low;    // per point of the soles: how well it can carry there
  std::vector<Foot> feet;     // per leg
  bool drags = false;         // nothing rests, and it does not fly: what is lowest carries

  void clear(size_t legs);
  // Reads the pose `qpos` (the model's) of a person whose feet are turned as `work` has them.
  void read(const Model& m, const FootingModel& model, const Footwork& work, const View& view,
            const double* qpos);
  // The pose with the hips of the body.
  const Kinematics& body() const { return tilts_ ? tilted_ : kin; }
  bool tilts() const { return tilts_; }
  bool flies() const { return flight_.flies(); }
  // How far a point of the soles goes along the ground in a time, as it is seen, if it goes on to lose speed as it
  // does [m]; and how fast it rises [m/s].
  Vec3 goes(size_t point, double time) const;
  double rises(size_t point) const { return velocity_[point].z; }
  // How much of what carries somebody a foot is: 0 to 1.
  double carries(const Foot& foot) const { return drags ? foot.low : foot.rests; }
  // Is a body of the model this person's?
  const char* own() const { return own_.data(); }
  Vec3 centre_of_mass(const Model& m) const;       // of the reference as it is seen [m]
  size_t count() const { return before_.size(); }  // of points
  // From the heading of the frame before to this one's; half-way to how the body is turned.
  Quat heading_change() const { return heading_ * conjugate(heading_before_); }
  Quat turned_half_way() const {
    return exp_quat(0.5 * (log_quat(turned_before_) + log_quat(turned_)));
  }
  // Who is turned goes along the motion's own path nevertheless: how far that takes it, in this frame, beside the way
  // that its turned feet make [m]:  (1 - R) dx,  R: how it is turned, dx: the way of the root in the motion.
  Vec3 goes_aside() const { return aside_; }
  // The reference with its root turned about `by`, into `out` [nq of the model].
  void turn_root(const Model& m, const double* qpos, Quat by, std::vector<double>& out) const;

  void save(std::vector<double>& out) const;
  const double* load(const double* in, const FootingModel& model);

 private:
  void turn(Quat turned);
  void pose(const Model& m, const double* qpos);
  void find_points(const FootingModel& model, const View& view);
  void find_rest(const FootingModel& model, const Footwork& work, double waits, double dt);

  Flight flight_;
  std::vector<Vec3> before_;    // points of the last reference pose
  std::vector<Vec3> velocity_;  // and how they came there [m/s]
  Vec3 root_before_;            // of the last reference pose [m]
  bool started_ = false;        // these are known
  Quat turned_, heading_;       // of the body off the motion, and about the vertical alone
  // Of the frame under way.
  Quat turned_before_, heading_before_;
  Vec3 aside_;
  Kinematics tilted_;
  bool tilts_ = false;
  int root_ = 0;
  std::vector<Vec3> own_points_;  // the points in the reference itself
  std::vector<double>
      loses_;  // share of its speed along the ground that each has lost, in a second [1/s]
  std::vector<char> own_;
  std::vector<double> turned_qpos_;
};

}  // namespace hp
