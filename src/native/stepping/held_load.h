// Held objects: what they ask of the drive, and joints that are too weak for it.
//
// A held object is a body of a person's tree that no joint moves. A person has neither weight nor
// inertia while following the motion; what they hold has both. The generalised force [N, N m] that
// it asks for, by being where the motion takes it, is that of inverse dynamics with the held bodies
// as the only masses:
//
//   load = M_held dv_ref/dt + (Coriolis, centrifugal, gravity)_held
//
// The drive bears it: a person who is strong enough follows the motion as if nothing were held.
// Where a joint is too weak it exerts what it can and gives way like dry friction. Without contact
// a substep changes the deviation of velocity by x with M x = u - h load, u the impulse of the
// drive, |u_j| <= h tau_j. With x = wanted + y the answer is the convex problem
//
//   u_j = limit_j against y_j where y_j is not zero, |u_j| <= limit_j where it is,
//
// solved as a sequence of linear problems with resistances limit_j / |y_j| (iteratively
// reweighted).
#pragma once
#include <vector>

#include "stepping/data.h"

namespace hp {

class HeldLoad {
 public:
  void finish(const Model& m) { load_.assign(m.nv, 0); }
  // The load of all active people at the present pose, for a substep of length h.
  void find(const System& system, const State& state, double h);
  const std::vector<double>& force() const { return load_; }  // per dof
  // Joints that are too weak for their v* give way: corrects step.v_free.
  void bear(System& system, Data& data, double h) const;

 private:
  void add_drift(const System& system, const State& state, const Drive& d, double h,
                 const std::vector<double>& held, const std::vector<double>& own, double sign);
  void bear(System& system, Data& data, const Drive& d, double h) const;

  std::vector<double> load_;
};

}  // namespace hp
