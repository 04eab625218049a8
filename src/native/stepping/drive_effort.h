// What a drive exerted in a frame: the sum of its generalised impulses [N s, N m s] over the
// substeps (strength.h has the equation), and their mean force over the frame.
#pragma once
#include <algorithm>
#include <vector>

namespace hp {

class DriveEffort {
 public:
  explicit DriveEffort(int dofs) : impulse_(dofs, 0) {}
  bool any() const { return any_; }  // the drive exerted something
  void begin_frame() { any_ = false; }
  void drop() { any_ = false; }
  // Adds the impulse of a substep, per dof of the person.
  void add(const double* impulse) {
    if (!any_) std::fill(impulse_.begin(), impulse_.end(), 0.0);
    any_ = true;
    for (size_t i = 0; i < impulse_.size(); i++) impulse_[i] += impulse[i];
  }
  // The mean generalised force over a frame of length dt, root first; empty if there was none.
  std::vector<double> mean_force(double dt) const {
    if (!any_) return {};
    std::vector<double> out(impulse_);
    for (double& f : out) f /= dt;
    return out;
  }

 private:
  std::vector<double> impulse_;
  bool any_ = false;
};

}  // namespace hp
