// What the solve of an island may cost, in multiplications and never by the clock: a solve that ends by
// its budget ends so on every machine.
#pragma once
#include "tuning.h"

namespace hp {

class WorkBudget {
 public:
  void begin(double most) {
    most_ = most;
    work_ = 0;
  }
  void spend(double work) { work_ += work; }
  double work() const { return work_; }
  double left() const { return most_ - work_; }
  bool spent() const { return work_ >= most_; }
  // May a sweep or a Newton step cost `work`? They leave a share to the normal impulses alone.
  bool affords(double work) const {
    return work_ + work <= (1 - tuning::contact::kNormalShare) * most_;
  }

 private:
  double most_ = 0, work_ = 0;
};

}  // namespace hp
