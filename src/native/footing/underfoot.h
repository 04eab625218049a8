// Underfoot: what is under a person's stance, and how far up it takes each part to stand on it.
//
// A soft layer carries anything from its frame up to its surface: there a part has two lifts, the least one,
// on the frame, and the one to just below the surface, from where on contacts carry it (on_layers.h).
//
// A foot that swings is looked at ahead of where it is too, a fifth of a second: static geometry that it comes to and
// that is higher than what is under it now, a stair, it has to pass over. Things it pushes.
#pragma once
#include <array>
#include <vector>

#include "footing/bearing.h"
#include "footing/stance.h"
#include "footing/surface_below.h"
#include "tuning.h"

namespace hp {

class Underfoot {
 public:
  struct Foot {
    double lift = -1e300;   // how far up it must be put to stand on the highest surface there [m]
    double least = -1e300;  // the same of the frames of layers [m]
    bool grounded = false;  // there is one
    // The lift with which it is over what it comes to in each of the next kLookTimes; -1e300: over nothing higher [m].
    std::array<double, tuning::footing::kLooks> soon;
    double stands = 1e300;  // height of the ground on which it rests [m]; 1e300: it does not rest
    bool on_layer() const { return least < lift; }
  };
  std::vector<Foot> feet;  // per leg
  std::vector<double>
      ground;  // where each point of the soles is to stand at least [m]; -1e300: anywhere

  // Looks below a stance that is at `displaced` and `height` above the reference [m], with its feet where
  // `work` has them. What can carry is told to `bearing`. A foot steps up where it swings: one that goes on
  // resting stays down, whatever the body is pushed over.
  void find(const CollisionWorld& world, Poses& poses, const FootingModel& model,
            const Stance& stance, const Footwork& work, Vec3 displaced, double height,
            Bearing& bearing);
  // Where a point of the soles that is at `x`, on its way, is to be at least [m]: over the ground that it comes to, if
  // that is below it already; -1e300: anywhere.
  double ground_at(const CollisionWorld& world, Poses& poses, SurfaceBelow& below, size_t point,
                   Vec3 x) const;
  // The lift of the skin that carries, if any but the feet's does.
  bool sits() const { return skin_lift_ > -1e300; }
  double skin_lift() const { return skin_lift_; }
  // The same of the frames of layers [m].
  double least_skin_lift() const { return std::min(least_skin_lift_, skin_lift_); }
  // Height of the highest ground under the feet; -1e300: none [m].
  double highest() const;
  // Of the ground on which a foot rests; 1e300: it does not [m].
  double stands(size_t foot) const { return foot < feet.size() ? feet[foot].stands : 1e300; }
  // What is known of a frame before; `stands` of every foot.
  void restore(double highest, double skin_lift, const std::vector<double>& stands) {
    ground.assign(1, highest);
    skin_lift_ = least_skin_lift_ = skin_lift;
    feet.assign(stands.size(), {});
    for (size_t f = 0; f < stands.size(); f++) feet[f].stands = stands[f];
  }

  // The least height at which nothing of a stance, its hands with the rest or not, is in static geometry that
  // is over it when displaced by `by`; -1e300: any.
  static double least_height(const CollisionWorld& world, const FootingModel& model,
                             const Stance& stance, Vec3 by, bool hands);
  // Can a foot be put down, moved by `by` and turned about the vertical by `turn`? All of its sole is over
  // ground that is no stair away.
  static bool lands(const CollisionWorld& world, Poses& poses, const Leg& leg, const Stance& stance,
                    Vec3 by, double turn);

 private:
  static void look_ahead(const CollisionWorld& world, const Stance& stance, SurfaceBelow& below,
                         const std::vector<double>& stands, size_t first, double high, Vec3 by,
                         double lowest, Foot& foot);
  void find_skin(const CollisionWorld& world, Poses& poses, const FootingModel& model,
                 const Stance& stance, Vec3 by, Bearing& bearing);

  double skin_lift_ = -1e300, least_skin_lift_ = -1e300;
};

}  // namespace hp
