// What a frame may cost, in multiplications and never by the clock: a step that ends by its budget ends
// so on every machine.
//
// A frame has a budget for every person in it. A substep may take its share of what is left of that, or
// kSpikeShare of it where that is more; what it does not take is left to the substeps after it. Where
// the budget of a substep ends, nothing is tried again: the step is shortened to what is verified, and
// the rest of it is lost (sub_stepping.h). Even that costs, in every substep: where the budget of the
// frame has ended, the substeps that are left are joined to as few as time allows (stepper.cpp).
#pragma once
#include <algorithm>

#include "tuning.h"

namespace hp {

class StepBudget {
 public:
  void begin_frame(int substeps, int people) {
    given_ = frame_ = tuning::stepping::kFrameWork * std::max(1, people) *
                      std::max(1.0, (double)substeps / tuning::stepping::kFrameSubsteps);
    spent_ = 0;
  }
  // The frame is made once more, from its start.
  void begin_frame_again() { frame_ = given_; }
  // So many substeps of the frame are left, this one included.
  void begin_substep(int left) {
    const double share = std::max(1.0 / std::max(1, left), tuning::stepping::kSpikeShare);
    left_ = share * std::max(0.0, frame_);
    least_ = tuning::stepping::kWorkReserve * left_;
    whole_ = true;
  }
  void spend(double work) { left_ -= work, frame_ -= work, spent_ += work; }
  // By the frame so far, in budgets of a frame.
  double spent() const { return given_ > 0 ? spent_ / given_ : 0; }
  bool out() const { return left_ <= least_; }
  // Nothing to speak of is left for any substep of the frame.
  bool frame_out() const { return frame_ <= tuning::stepping::kWorkReserve * given_; }
  // An island may take a share of what is left for an attempt: where that fails, shorter steps follow.
  // The first attempt at the whole substep may take more.
  void begin_attempt() {
    attempt_ = left_ * (whole_ ? tuning::stepping::kWholeShare : tuning::stepping::kAttemptShare);
    whole_ = false;
  }
  // Has an island that has taken `work` of this attempt to end it? One that takes little never has,
  // whatever others have taken.
  bool attempt_out(double work) const {
    return work >= std::max(attempt_, tuning::stepping::kLeastIslandWork);
  }
  // What the next solve may cost.
  double solve() const {
    return std::min(tuning::contact::kSolveWork, std::max(tuning::stepping::kLeastSolveWork,
                                                          tuning::stepping::kSolveShare * left_));
  }

 private:
  double given_ = 0, spent_ = 0;  // for the frame, by it
  double frame_ = 0, left_ = 0, least_ = 0, attempt_ = 0;
  bool whole_ = true;  // the next attempt is the first of its substep
};

}  // namespace hp
