#include "stepping/gentle_return.h"

#include "stepping/drive.h"
#include "tuning.h"

namespace hp {

namespace tune = tuning::stepping;

std::vector<double> return_rates(const PersonDofs& dofs, double speed,
                                 const std::vector<double>& reach) {
  std::vector<double> rates;
  for (const PersonDofs::Ball& b : dofs.balls())
    rates.push_back(speed / std::max(reach[b.body], tune::kLeastJointReach));
  return rates;
}

void GentleReturn::start(const PersonDofs& dofs, double speed, const std::vector<double>& reach) {
  if (left_ == 0) left_ = tune::kReturnTime;
  rate_ = return_rates(dofs, speed, reach);
}

void GentleReturn::end_frame(const PersonDofs& dofs, bool comes_out, double dt,
                             const double* target, const double* qpos) {
  if (comes_out) {
    left_ = tune::kReturnTime;
    return;
  }
  left_ = std::max(0.0, left_ - dt);
  for (const PersonDofs::Ball& b : dofs.balls())
    if (norm(rotation_between(target + b.qpos, qpos + dofs.first_qpos() + b.qpos)) >
        tune::kReturnAngle)
      return;
  left_ = 0;
}

}  // namespace hp
