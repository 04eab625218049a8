// How the samples of one shape press on one layer, in one step.
//
// A sample is pressed in by d = t_sample + t_layer - g, g the distance of its hard point from the layer's
// hard frame. It stands for a flat piece of the surface: where the piece is askew to the layer by an angle
// a, its depths spread over d +- e, e = sqrt(A)/2 sin a, and its pressure is the mean over them, in closed
// form. So the rim of a contact moves over the samples evenly. Its area counts as the layer sees it,
// A cos a.
//
// Two rules for the pressure of a step from depth d0 to d1:
//
//     Rule::End    p(d1) + c (d1 - d0)/h                      implicit Euler: loses energy, never gains it
//     Rule::Mean   (Psi(d1) - Psi(d0))/(d1 - d0) + c (d1 - d0)/h     a discrete gradient: the springs'
//                  energy is kept to rounding; Psi their energy
//
// With Mean the step moves by half of the impulse and the velocity that is kept has all of it: then the work
// over the way that is made is what the springs store.
#pragma once
#include <cstdint>

#include "soft/frame_distance.h"
#include "soft/near_samples.h"
#include "soft/sample_poses.h"

namespace hp {

enum class Rule : char { End, Mean };
// The share of a step's impulse that moves the step.
inline double moving_share(Rule rule) { return rule == Rule::End ? 1.0 : 0.5; }

// What is known of a sample from when it was last measured.
//
// It saves measuring and changes nothing: samples are near whose distance g from the frame is at most
// t + e + reach, t the most that both layers are thick, e half of the piece that it stands for, reach what it may
// go in the step. Distances from a set change by no more than the point moves relative to it, so that after the
// two have travelled s more g is at least what it was less s. A sample that is passed over for that would,
// measured, be found as far and be passed over too. So a simulation without this knowledge, restored from its
// state, goes on with the same bits.
class SeenSamples {
 public:
  void clear() { until_.clear(), triangle_.clear(); }
  // Nothing is known of n, if there are fewer.
  void resize(int n);
  // Not to be found again, unless it is put here.
  void take(int sample) { until_[sample] = kNever; }
  // Its distance from the frame less t + e is `room` at least, when the two have travelled so far in all
  // [m]. Returns how far they may go before it can come to 0.
  double put(int sample, int triangle, double room, double travelled) {
    triangle_[sample] = triangle;
    return until_[sample] = room + travelled;
  }
  // Where a search for it begins, of a mesh.
  int triangle(int sample) const { return triangle_[sample]; }
  // Appends those that may be near when the two have travelled so far, in their order. Returns how far they may
  // go before any other can be.
  double find(double travelled, std::vector<int>& out) const;

 private:
  static constexpr double kNever = 1e300;
  static constexpr int kBlock = 16;
  std::vector<double> until_;  // in whole blocks; -kNever: nothing is known
  std::vector<int> triangle_;
};

// One shape and what it may press on.
struct SoftPair {
  int shape = 0, other_static = -1, other_shape = -1;
  int group = 0;         // pairs of one body and one other are condensed together
  double thickness = 0;  // of both layers, at most [m]
  // The shape is at least `room` off the frame, minus what it has travelled since `room_at`; < 0: unknown.
  double room = -1, room_at = 0;
  uint64_t stamp = 0;  // of the pose at the start that `near` was found for, as far as `reach`
  double reach = 0;
  uint64_t measured = 0;  // stamp of the pose that samples were measured at last
  NearSamples near;
  SeenSamples seen;  // per sample, of those that are not near
  // None of those comes within `reach` before the two have travelled so far, less reach.
  double quiet = -1e300;

  void forget() {
    room = -1, stamp = measured = 0, quiet = -1e300;
    near.clear(), seen.clear();
  }
};

FrameDistance frame_of(const CollisionWorld& world, const SoftWorld& soft, Poses& pose,
                       const SoftPair& pair);

// What foam remembers of the layer that a pair presses, and where.
struct FoamFrame {
  int layer = 0;      // a static's number, or minus a shape's, less 1
  bool moves = true;  // else its frame is the world's
  Vec3 origin;
  Mat3 axes;
  FoamCell around(Vec3 x) const {
    return FoamCell::around(layer, moves ? mul_t(axes, x - origin) : x);
  }
};
FoamFrame foam_frame(const CollisionWorld& world, const Poses& pose, const SoftPair& pair);

// Finds the samples that are within `reach` of the layer's surface at the start of a step, when the two have
// travelled so far in all [m]. What was measured at this pose when it was the end of a step is kept.
void find_near(const CollisionWorld& world, const SoftWorld& soft, const FoamCells& cells,
               Poses& start, double reach, double travelled, SoftPair& pair);
// The depths at an end pose, to which the two have gone no farther than `way` [m]. False if no sample is
// pressed there.
bool find_depths(const CollisionWorld& world, const SoftWorld& soft, Poses& end, double way,
                 SoftPair& pair);
// A guess of the depths at the end, without measuring: as if the samples went on with the twist (v, w about
// the origin) relative to the layer, from where they are at the start.
void guess_depths(double h, Vec3 v, Vec3 w, SoftPair& pair);
// The part of a sample's piece that is pressed at the end pose: its share of the area, and its mean
// depth [m].
struct PressedPart {
  double share = 1, depth = 0;
};
PressedPart pressed_part(const NearSamples& near, int i);
// The pressures of a step of length h [s] that ends there.
void find_pressures(Rule rule, double h, SoftPair& pair);
// Is there any?
bool presses(const SoftPair& pair);
// How far the dashpots of its samples have gone in that step.
void find_went(double h, SoftPair& pair);
// The energy that the samples' springs have given back in that step, less what their dampers have
// taken [J]; of a skin it is not known.
double given_back(double h, const SoftPair& pair);
// That step has been made, to that pose: what foam remembers of it, after find_went().
void remember(const CollisionWorld& world, const Poses& end, SoftPair& pair, FoamCells& cells);

}  // namespace hp
