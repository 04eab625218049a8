// Footwork: feet keep their places on the ground while the body is moved beside its motion, and step when
// they are left behind.
//
// Where a foot is put, beside where the body carries it, is a place in two numbers: an offset c along the
// ground and an angle p about the vertical. Somebody who is pushed, turned, or on the way back to the path moves
// beside the motion; a foot that rests does not, so that c and p grow the other way. In the air it goes to
// where it will be needed, ahead of the body by half of what it will be left behind while it stands:
//
//   c -> v kStance / 2    (v: speed of the body beside its motion, smoothed [m/s])
//
// Who waits stands on both feet: they are put down where they are, level, and that is their place, or where a step
// has ended since, as far as the leg reached (else they would step on the spot for ever); only of
// who waits is a foot that something keeps from its place left where it is.
//
// What a motion's own steps do not take back, others do: of two feet that rest the one that is
// farther from its place is lifted, as long as the other carries, and put down there. It moves in the world along a
// path of least jerk, whose end follows the body at first.
#pragma once
#include <functional>
#include <vector>

#include "math/vec.h"

namespace hp {

class Footwork {
 public:
  // A foot in a frame.
  struct Foot {
    double rests = 0;       // 0: the motion moves it, 1: it rests
    double rested = 0;      // for how long [s]
    bool grounded = false;  // there is ground under it
    bool stands = false;    // and it stands there
    Vec3 slid;          // how far the body has carried it along the ground, beside its motion [m]
    double turned = 0;  // and about the vertical [rad]
    bool held = false;  // it rests because the person waits
    Vec3 missed;        // how far it is now from where it was to be, along the ground [m]
  };
  // May a foot be put down at an offset, turned by an angle?
  using Lands = std::function<bool(size_t foot, Vec3 offset, double turn)>;

  // A frame of length dt [s]; `free`: the person stands on its feet alone, and may step.
  void frame(const std::vector<Foot>& feet, bool free, double dt, const Lands& lands);
  void clear(size_t feet);

  Vec3 offset(size_t foot) const { return places_[foot].offset; }    // c [m]
  double turn(size_t foot) const { return places_[foot].turn; }      // p [rad]
  double raised(size_t foot) const { return places_[foot].raised; }  // of a foot that steps [m]
  bool steps(size_t foot) const { return steps_ == (int)foot; }
  // In this frame it was found elsewhere, and stays there.
  bool stopped(size_t foot) const { return places_[foot].stopped; }
  // The leg reached an offset of `made` only.
  void reached(size_t foot, Vec3 made) { places_[foot].offset = {made.x, made.y, 0}; }
  // Share of its pace at which a body may go back along `way`, so that its feet can follow.
  double pace(Vec3 way) const;

  void save(std::vector<double>& out) const;
  const double* load(const double* in, size_t feet);

 private:
  struct Place {
    Vec3 offset;
    Vec3 home;  // its offset while the body is in its place; of who waits not 0
    double turn = 0, raised = 0;
    bool rests = false, held = false, stopped = false;
  };
  Vec3 wanted(const Place& place) const;
  double late(const Place& place) const;
  void begin_step(const std::vector<Foot>& feet, const Lands& lands);
  static bool hangs(const Foot& foot, const Place& place);
  static bool others_stand(const std::vector<Foot>& feet, size_t foot);
  void step(double dt);
  static double most(const Place& place);
  static void stay(Place& place, Vec3 missed);
  static void limit(Place& place);

  std::vector<Place> places_;
  Vec3 speed_;                   // v
  double spin_ = 0;              // the same about the vertical [rad/s]
  int steps_ = -1;               // the foot that steps
  double time_ = 0, lasts_ = 0;  // of the step so far, and in all [s]
  int landed_ = -1;              // the foot whose step has ended in the last frame
  double share_ = 1;             // of the wanted offset at which there is ground
  Vec3 to_;                      // where it ends, as seen now: an offset [m]
};

}  // namespace hp
