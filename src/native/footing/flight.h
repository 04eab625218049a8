// Does a reference fly, or is its lowest point what carries it?
//
// What nothing holds up gains g downwards, and what jumps off leaves the ground: then a person keeps the
// height that it has. Anybody else is carried by something; where nothing of it rests, as in a dance on
// sliding feet, by what is lowest. The gain is that of the root's height z against its own past:
//
//   z' - u < -kFlies g kFlightTime,   kFlightTime u' = z' - u
//
// Who stands does not begin to fly by gaining so much: a walk does, where its trunk comes down on the next foot.
#pragma once
#include <vector>

#include "math/vec.h"

namespace hp {

class Flight {
 public:
  // A frame of the reference, `time` after the one before [s] (none: it stands still): the height of its root
  // and that of its lowest point [m]; `rests`: something as low as this is still.
  void see(double root, double lowest, bool rests, double time, double gravity);
  bool flies() const { return flies_; }
  double lowest() const { return lowest_; }

  void save(std::vector<double>& out) const;
  const double* load(const double* in);

 private:
  bool seen_ = false, flies_ = false;
  double root_ = 0, lowest_ = 0;
  double past_ = 0;  // u [m/s]
};

}  // namespace hp
