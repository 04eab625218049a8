// Footing: people stand on what is under them (docs/physics.md, "Weight").
//
// A motion knows nothing of the ground of the scene: recorded feet float over it or sink into it,
// by centimetres, and stairs or a mattress are at another height than where it was recorded. Before
// a frame is simulated its target is corrected, with two numbers for every person's state:
//
//   height  d   of the whole person, moved slowly, like a critically damped spring, towards what the
//               soles (or seat, back, knees) that rest need to stand on what is under them. It
//               falls no faster than gravity has it: nobody is held up by nothing.
//   shift   c_f of each foot, for what is left: hip, knee and ankle bend (leg.h). A foot
//               that rests also keeps its place on the ground while the root is off its path.
//
// What rests is read from the reference: what is slow and low. A sole that would be under a surface
// is lifted whether it rests or not, and nothing that is over the static ground gets into it as the
// person comes down. A motion whose feet are at the ground is not changed by one bit,
// and where there is nothing under a person nothing is corrected.
#pragma once
#include <memory>
#include <vector>

#include "footing/bearing.h"
#include "footing/flight.h"
#include "footing/leg.h"
#include "footing/surface_below.h"

namespace hp {

// What footing knows of a person's body.
struct FootingModel {
  std::vector<Leg> legs;
  std::vector<SkinPoint> skin;   // all over the body, but feet and hands
  std::vector<SkinPoint> hands;  // they reach, and carry nobody
};

class Footing {
 public:
  std::shared_ptr<const FootingModel> model;  // none: off
  Bearing bearing;                            // what it weighs on

  bool on() const { return model != nullptr; }
  // Has the last frame's target been corrected?
  bool corrected() const { return corrected_; }
  // Is there a surface anywhere under the person, and is it on it? Else it falls or jumps.
  bool over_ground() const { return over_ground_; }
  bool on_ground() const { return on_ground_; }
  // Both feet rest, or something else carries.
  bool at_rest() const { return at_rest_; }
  // Skin but the feet's carries it.
  bool sits() const { return skin_lift_ > -1e300; }
  // Is this body the toes of a foot that rests on the ground?
  bool bears(int toes) const;

  // The person starts at `qpos` (the model's): it is put on what is under it, if that is near.
  // `root_qpos`: its first coordinate.
  void start(const Model& m, const CollisionWorld& world, Poses& poses, int root_qpos,
             double* qpos);
  // Nothing is known of the person; after start(): it starts as asked instead.
  void clear();
  // The person is so much higher than where it was put, and something holds it there [m].
  void raise(double by) { height_ += by, rising_ = 0; }
  struct Frame {
    double dt;           // [s]
    double passed;       // how much of the reference's time passes [s]
    double gravity;      // [m/s^2]
    const double* from;  // the corrected target before: qpos of the person
    Vec3 displaced;      // how far the root will be off its path, and is above it now [m]
  };
  // A frame towards the pose in `target` (the model's qpos), which is corrected.
  void frame(const Model& m, const CollisionWorld& world, Poses& poses, int root_qpos,
             const Frame& frame, double* target);

  void save(std::vector<double>& out) const;
  const double* load(const double* in);

 private:
  // One leg over one frame.
  struct Foot {
    double low = 0;    // 1: no part of the person is lower
    double rests = 0;  // 0: it moves, 1: it rests
    double lift = 0;   // how far up it must be put to stand on the highest surface under it [m]
    bool grounded = false;  // there is a surface under it
    bool bears = false;     // and it is there, and rests more or less
  };
  void read(const Model& m, const double* qpos, double time, double gravity);
  void find_feet(const CollisionWorld& world, Poses& poses, Vec3 displaced, double dt);
  void find_skin(const CollisionWorld& world, Poses& poses, Vec3 displaced);
  bool wanted_height(double& height) const;
  double least_height(const CollisionWorld& world, Vec3 by) const;
  void come_down(const CollisionWorld& world, Vec3 displaced, double from, double dt);
  void move_height(double dt, double gravity);
  Vec3 wanted_shift(size_t leg, Vec3 displaced, double dt);
  void find_state();
  void find_bearing(const Model& m, const CollisionWorld& world, Vec3 displaced);
  void apply(int root_qpos, double* qpos);
  bool clear_between(const Model& m, int root_qpos, const double* from, const double* to);

  double height_ = 0, rising_ = 0;  // d [m] and its speed [m/s]
  std::vector<Vec3> shift_;         // c_f [m], per leg
  Flight flight_;                   // of the reference
  std::vector<double> rested_;      // how long each foot has rested [s]
  std::vector<double> sinking_;     // speed of each foot on its way down to what it stands on [m/s]
  std::vector<Vec3> before_;        // points of the last reference pose: soles, then skin
  Vec3 displaced_;                  // of the last frame
  bool started_ = false;            // `before_` is known
  bool corrected_ = false;
  bool over_ground_ = false, on_ground_ = false, at_rest_ = false;  // in this frame

  // Of the frame under way.
  Kinematics kin_, between_;  // of the reference; half-way to the target
  std::vector<double> asked_, half_;
  std::vector<char> own_;
  std::vector<Vec3> points_;
  std::vector<double> speed_;
  std::vector<double> ground_;  // height under each point of the soles; -1e300: none
  std::vector<Foot> feet_;
  double skin_lift_ = -1e300;  // that skin takes which carries; else this
};

}  // namespace hp
