// Standing friction: whoever stands, sits or lies on a movable thing holds it by friction.
//
// As its weight (standing_load.h), this acts on the thing alone: the person is where its motion and its
// legs have it. How much it presses with is known, so friction's bound is, too (Tresca's law): at each
// point whose speed is known (footing/bearing.h), per substep of length h, an impulse p along the ground with
//
//   |p| <= mu N h,   and where the thing still moves past the sole, p = -mu N h w/|w|,
//
// w the thing's velocity less the sole's. It is solved with the contacts, as a row of theirs whose normal
// part is nobody's: with n = 0 its operator is the compliance 1 alone, and the answer to its demand N h is
// p_n = N h, whatever moves.
//
// Weight comes while a sole or a seat is still some way above what it will rest on; friction does when its nearest
// point is there.
//
// The points of one body of a person on one thing are condensed into two that have the same load, centre
// of pressure and lever about it: half of the load each, one radius of gyration from the centre along the
// longer axis. So a foot holds a turntable as well.
#pragma once
#include <vector>

#include "stepping/data.h"

namespace hp {

class StandingFriction {
 public:
  // Rows for an attempt at a step of length h [s], into attempt.standing: as gravity and weight, with all of the
  // substep's in whatever part of it is tried first, and with none after one is made.
  void find(const System& system, Data& data, double h);
  // Islands in which a thing would slip under somebody at v* are to be solved.
  void look(const System& system, Data& data);
  // A step is made, by the trees' shares of it (sub_stepping.h).
  static void record(const System& system, Data& data, const std::vector<double>& share);

 private:
  // What one body of a person presses on one thing with.
  struct Patch {
    int shape = 0, body = 0;  // of the thing; of the person
    double force = 0;         // [N]
    double gap = 1e300;       // of its nearest point [m]
    Vec3 at, velocity;        // means by force [m], [m/s]
    double xx = 0, xy = 0, yy = 0,
           turning = 0;  // second moments [N m^2], and of velocity [N m^2/s]
  };
  Patch& patch(int shape, int body);
  void collect(const System& system, const Drive& d);
  static void add_rows(const System& system, const Patch& patch, double h, double whole,
                       std::vector<StandingRow>& rows);

  std::vector<Patch> patches_;
  std::vector<Twist> twists_;
};

}  // namespace hp
