// Bearing: which points of a person carry its weight, and how much of it each.
//
// Points that rest near a surface can carry; `carries` in [0, 1] says how well. The weight is spread
// over them with shares s_i > 0, sum s_i = 1, so that the centre of pressure is as near to the ground point
// c under the centre of mass as they allow. Of all such spreads the one that is nearest to
// w_i = carries_i / sum carries (least relative entropy):
//
//   s_i ~ w_i exp(a . (x_i - c)),   a = argmin  log sum w_i exp(a . (x_i - c)) + e/2 |a|^2
//
// a smooth convex problem in two unknowns, by Newton's method. Its answer has  sum s_i x_i = c - e a:
// the moments are right where c is between the points, and the nearest points carry where it is not. It
// changes smoothly with the points.
//
// Only what rests on movable things is a load; the shares of static geometry are dropped, and soft layers carry
// by contacts. Loads
// follow their targets with a time constant. What leaves its surface is no load any more.
#pragma once
#include <vector>

#include "math/vec.h"

namespace hp {

struct BearingPoint {
  Vec3 at;                // on the surface under it, in the world [m]
  int shape = -1;         // that surface's, if it can be moved; -1: static geometry, or none
  double carries = 0;     // 0: not at all
  bool on_layer = false;  // what carries is soft: contacts do (on_layers.h)
  // How fast the point goes along the ground where it is put [m/s], and whether that is known: it is that of
  // the last two frames in which it carried.
  Vec3 velocity;
  bool timed = false;
  double gap = 0;  // to the surface, beyond what contacts keep [m]
};

// The shares of `points` for a person whose centre of mass is over `centre`, into `share`; all zero
// where nothing carries.
void spread_weight(const std::vector<BearingPoint>& points, Vec3 centre,
                   std::vector<double>& share);

class Bearing {
 public:
  std::vector<BearingPoint> points;  // of the frame under way

  // The points of a frame of length dt [s] are known: how fast each goes, and what it is to carry, of the
  // share `left` of the weight.
  void aim(Vec3 centre, double left, double dt);
  // Time `h` [s] passes.
  void advance(double h);
  // Does anything press on a movable thing?
  bool any() const;
  // What point i presses with, in the person's weight, beside what contacts do.
  double load(size_t i) const { return i < load_.size() ? load_[i] * left_ : 0; }
  double total() const;  // without what contacts do
  // Contacts pressed on movable things with so much of the weight, on average, for a time dt [s].
  void contacts_pressed(double weights, double dt);

  void reset();
  void save(size_t count, std::vector<double>& out) const;
  const double* restore(size_t count, const double* in);

 private:
  // A point in the frame before: whether it carried, and then where; and its velocity.
  struct Before {
    bool carried = false, timed = false;
    double x = 0, y = 0;
    Vec3 velocity;
  };
  void find_velocities(double dt);

  std::vector<Before> before_;
  std::vector<double> target_, load_;  // per point, in the person's weight; loads outlive a frame
  double pressed_ = 0;                 // by contacts, smoothed, in the person's weight
  double left_ = 1;                    // share of the load that contacts leave
};

}  // namespace hp
