// Footing: people stand on what is under them (docs/physics.md, "Weight").
//
// A motion knows nothing of the ground of the scene: recorded feet float over it or sink into it,
// by centimetres, and stairs or a mattress are at another height than where it was recorded. Before
// a frame is simulated its target is corrected, with two numbers for every person's state:
//
//   height  d   of the whole person, moved slowly, like a critically damped spring, towards what the
//               soles (or seat, back, knees) that rest need to stand on what is under them. It
//               falls no faster than gravity has it: nobody is held up by nothing.
//   lift    u_f of each foot, for what is left: hip, knee and ankle bend (leg.h).
//
// Somebody who is off the path, or turned off it, stands there: the reference is seen from where the body
// is, turned about the vertical like it, and its feet keep their places on the ground, or step to others
// (footwork.h). A body that is tilted stands on level feet: the legs make up for it.
//
// What rests is read from the reference: what is slow and low. A sole that would be under a surface
// is lifted whether it rests or not, and nothing that is over the static ground gets into it as the
// person comes down. While soft layers carry it the height is theirs (on_layers.h), and its feet wade
// (wading.h). A motion whose feet are at the ground is not changed by one bit, and where there is
// nothing under a person nothing is corrected.
#pragma once
#include <memory>
#include <vector>

#include "footing/bearing.h"
#include "footing/footing_model.h"
#include "footing/footwork.h"
#include "footing/on_layers.h"
#include "footing/stance.h"
#include "footing/underfoot.h"
#include "footing/wading.h"
#include "footing/way_round.h"

namespace hp {

class Footing {
 public:
  std::shared_ptr<const FootingModel> model;  // none: off
  Bearing bearing;                            // what it weighs on
  OnLayers layers;                            // and how much of it soft layers carry
  Wading wading;                              // how feet leave these and come down on them
  WayRound way;                               // back to the path

  bool on() const { return model != nullptr; }
  // Has the last frame's target been corrected?
  bool corrected() const { return corrected_; }
  // Is there a surface anywhere under the person, and is it on it? Else it falls or jumps.
  bool over_ground() const { return over_ground_; }
  bool on_ground() const { return on_ground_; }
  // Does the motion fly?
  bool flies() const { return stance_.flies(); }
  // Skin but the feet's carries it.
  bool sits() const { return under_.sits(); }
  // Layers carry it, on its feet.
  bool wades() const { return layers.carry() && !sits(); }
  // In this frame it would sink below what the frame of a layer lets it.
  bool bottoms() const { return bottoms_; }
  // How much of its height is the layers', where it falls by its weight and is held by pressure: 1, or less
  // where it is so far below what a frame lets it that its legs are folded. There it stands as on hard ground.
  double sinks() const { return layers.carry() ? 1 - folds_ : 0; }
  // Height of the highest ground under the feet; -1e300: none [m].
  double ground() const { return under_.highest(); }
  // Is this body the toes of a foot that rests on the ground?
  bool bears(int toes) const;
  bool has_toes(int body) const {  // is it the toes of a foot?
    for (const Leg& leg : model->legs)
      if (leg.toes == body) return true;
    return false;
  }
  // The joints of this leg go on from where they are: its foot is elsewhere than it was to be.
  bool goes_on(size_t leg) const { return footwork_.stopped(leg); }
  // Share of its pace at which the root may go back along `way`, so that feet can follow.
  double pace(Vec3 way) const { return on() && !sits() ? footwork_.pace(way) : 1; }

  // The person starts at `qpos` (the model's): it is put on what is under it, if that is near.
  // `root_qpos`: its first coordinate.
  void start(const Model& m, const CollisionWorld& world, Poses& poses, int root_qpos,
             double* qpos);
  // Nothing is known of the person; after start(): it starts as asked instead.
  void clear();
  // How much higher than in the motion it is put [m].
  double height() const { return height_; }
  // The person is so much higher than where it was put, and something holds it there [m].
  void raise(double by) { height_ += by, rising_ = 0; }
  // How much of such a change layers make of the person's height: no frame is passed on the way down [m].
  double sink(double by) const { return std::max(by, std::min(0.0, least_height() - height_)); }
  struct Frame {
    Stance::View view;
    const double* from = nullptr;  // the corrected target before: qpos of the person
    Vec3 displaced;                // how far the root will be off its path, and is above it now [m]
    Vec3 returns;                  // how far the root is to go back to its path in the frame [m]
    double held_up = 0;            // how far contacts hold who sits or lies above its height [m]
    double rises = 0;  // how much higher layers will have it at the end of the frame [m]
  };
  // A frame towards the pose in `target` (the model's qpos), which is corrected.
  void frame(const Model& m, const CollisionWorld& world, Poses& poses, int root_qpos,
             const Frame& frame, double* target);

  void save(std::vector<double>& out) const;
  const double* load(const double* in);

 private:
  Leg::Place place(size_t leg) const;
  // Where the person is to be; not known: nothing rests, the height stays.
  struct Height {
    bool known = false;
    double at = 0;       // [m]
    bool hangs = false;  // a leg that is to carry reaches no farther down
  };
  Height wanted_height(bool starts) const;
  void come_down(const CollisionWorld& world, Vec3 displaced, double from, double dt);
  void move_height(double dt, double gravity);
  double wanted_lift(size_t leg, double height, double rose, double rises, double dt);
  double lift_for_soon(size_t leg, double height, double gap, double dt) const;
  Footwork::Foot moved_foot(const Poses& poses, size_t leg, Vec3 slid, const Frame& frame) const;
  void wade(const Model& m, double dt);
  // On its feet on layers nobody is lower than the frame under the foot that carries most has them.
  double least_height() const { return wades() ? wading.least() : -1e300; }
  void move_feet(const CollisionWorld& world, Poses& poses, const Frame& frame);
  void find_left(const Poses& poses, double dt);
  void find_state();
  void find_bearing(const Model& m, const CollisionWorld& world, Vec3 displaced, double dt);
  void apply(int root_qpos, double* qpos);
  bool clear_between(const Model& m, const CollisionWorld& world, Poses& poses, int root_qpos,
                     const double* from, const double* to);

  double height_ = 0, rising_ = 0;  // d [m] and its speed [m/s]
  std::vector<double> lift_;        // u_f [m], per leg
  Footwork footwork_;               // and their places along the ground
  std::vector<Vec3> placed_;        // where the ankles were to be at the end of the last frame [m]
  bool placed_known_ = false;
  std::vector<double> left_up_;  // how far a foot that was stopped is still above its place [m]
  std::vector<Vec3> left_turn_;  // and how it is still turned, a rotation vector in the world [rad]
  std::vector<double> sinking_;  // speed of each foot on its way down to what it stands on [m/s]
  Vec3 displaced_;               // of the last frame
  Stance stance_;                // of the reference
  Underfoot under_;              // what is under it
  bool corrected_ = false;
  bool over_ground_ = false, on_ground_ = false;  // in the last frame
  bool bottoms_ = false;
  double folds_ = 0;
  double held_up_ = 0;  // of the frame

  // Of the frame under way.
  Kinematics between_;  // half-way to the target
  std::vector<double> asked_, half_;
};

}  // namespace hp
