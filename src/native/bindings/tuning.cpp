// Constants of the core that Python shares (tuning.h): attributes of the class `tuning`.
#include "tuning.h"

#include "bindings/module.h"

namespace {

struct Tuning {};

}  // namespace

void bind_tuning(nb::module_& m) {
  using namespace hp::tuning;
  nb::class_<Tuning> shared(m, "tuning", "Constants of the core that Python shares: see tuning.h.");
  const auto add = [&](const char* name, auto value) { shared.attr(name) = value; };
  add("least_clearance", collision::kWearFloor);
  add("root_recovery_time", stepping::kRootRecoveryTime);
  add("return_per_motion", stepping::kReturnPerMotion);
  add("limp_time", stepping::kLimpTime);
  add("untouched_resistance", stepping::kUntouchedResistance);
  add("range_lever", stepping::kRangeLever);
  add("range_return", stepping::kRangeReturn);
  add("fastest_internal_spin", stepping::kFastestInternalSpin);
  add("velocity_rounding", stepping::kVelocityRounding);
  add("pull_share", stepping::kPullShare);
  add("resist_share", stepping::kResistShare);
  add("resist_rounds", stepping::kResistRounds);
  add("yield_tolerance", stepping::kYieldTolerance);
  add("safe_yield_rounds", stepping::kSafeYieldRounds);
  add("yield_rounds", stepping::kYieldRounds);
  add("yield_over_relaxation", stepping::kYieldOverRelaxation);
  add("least_yield_rate", stepping::kLeastYieldRate);
  add("rigid_resistance", stepping::kRigidResistance);
}
