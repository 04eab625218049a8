// The gentle return of a person who came out of an initial overlap: until all joints are back at
// the motion, but for the root's position, or for half a second, no point goes faster than
// kReturnSpeed on any joint's account. A joint that moves points up to `reach` [m] turns back at
// speed / reach [rad/s] at most.
#pragma once
#include <vector>

#include "stepping/person_dofs.h"

namespace hp {

// How fast each ball turns, at most, so that no point goes faster than `speed` [m/s] on its account [rad/s];
// `reach` is per body of the model [m].
std::vector<double> return_rates(const PersonDofs& dofs, double speed,
                                 const std::vector<double>& reach);

class GentleReturn {
 public:
  bool active() const { return left_ > 0; }
  double rate(size_t ball) const { return rate_[ball]; }  // most that it turns [rad/s]
  double left() const { return left_; }                   // time left [s]
  void stop() { left_ = 0; }
  // Begins, or goes on with what is left; `reach` is per body of the model.
  void start(const PersonDofs& dofs, double speed, const std::vector<double>& reach);
  void restore(double left) { left_ = left; }
  // A frame of length dt has ended at `qpos`. The return lasts as long as the person comes out of
  // something, and then until the joints are at `target`.
  void end_frame(const PersonDofs& dofs, bool comes_out, double dt, const double* target,
                 const double* qpos);

 private:
  double left_ = 0;
  std::vector<double> rate_;  // per ball
};

}  // namespace hp
