#include "footing/flight.h"

#include <cmath>

#include "tuning.h"

namespace hp {

namespace tune = tuning::footing;

void Flight::see(double root, double lowest, bool rests, double time, double gravity) {
  if (seen_ && time > tune::kNoTime) {
    const double climbs = (root - root_) / time;
    const bool gains = climbs - past_ < -tune::kFlies * gravity * tune::kFlightTime;
    const bool leaves = lowest - lowest_ > tune::kMoves * time;
    flies_ = leaves || (gains && (flies_ || !rests));
    past_ += (1 - elementary::exp(-time / tune::kFlightTime)) * (climbs - past_);
  }
  seen_ = true;
  root_ = root, lowest_ = lowest;
}

void Flight::save(std::vector<double>& out) const {
  out.insert(out.end(), {seen_ ? 1.0 : 0.0, flies_ ? 1.0 : 0.0, root_, lowest_, past_});
}

const double* Flight::load(const double* in) {
  seen_ = in[0] != 0, flies_ = in[1] != 0;
  root_ = in[2], lowest_ = in[3], past_ = in[4];
  return in + 5;
}

}  // namespace hp
