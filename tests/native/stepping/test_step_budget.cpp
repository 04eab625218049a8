// What a frame, its substeps and its attempts may cost.
#include "stepping/step_budget.h"

#include <cmath>

#include "check.h"

namespace tune = hp::tuning::stepping;

namespace {

// However much is asked for, a frame spends no more than one solve beyond its budget.
void a_frame_ends(int substeps, int people) {
  hp::StepBudget budget;
  budget.begin_frame(substeps, people);
  double spent = 0;
  for (int k = 0; k < substeps; k++) {
    budget.begin_substep(substeps - k);
    while (!budget.out()) {
      budget.begin_attempt();
      double taken = 0;
      do {
        const double work = budget.solve();
        CHECK(work >= tune::kLeastSolveWork && work <= hp::tuning::contact::kSolveWork);
        budget.spend(work);
        spent += work;
        taken += work;
      } while (!budget.attempt_out(taken));
    }
  }
  const double most =
      tune::kFrameWork * people * std::max(1.0, (double)substeps / tune::kFrameSubsteps);
  CHECK(spent <= most + substeps * tune::kLeastSolveWork);
  CHECK(spent > 0.5 * most);
  CHECK(std::fabs(budget.spent() - spent / most) < 1e-9);
  budget.begin_frame_again();
  CHECK(std::fabs(budget.spent() - spent / most) < 1e-9);
}

void what_a_substep_leaves_is_left_to_the_next() {
  hp::StepBudget budget;
  budget.begin_frame(2, 1);
  budget.begin_substep(2);
  budget.begin_substep(1);  // the first took nothing
  budget.begin_attempt();
  const double most = tune::kWholeShare * tune::kFrameWork;
  CHECK(!budget.attempt_out(most - 1));
  CHECK(budget.attempt_out(most) && !budget.out());
  budget.spend(tune::kFrameWork);
  CHECK(budget.out());
}

// However much one island takes, others that need little do not see it.
void trouble_ends_no_other_island() {
  hp::StepBudget budget;
  budget.begin_frame(8, 2);
  budget.begin_substep(8);
  budget.begin_attempt();
  budget.spend(10 * tune::kFrameWork);
  CHECK(budget.out());
  budget.begin_attempt();
  CHECK(!budget.attempt_out(tune::kLeastIslandWork - 1));
  CHECK(budget.attempt_out(tune::kLeastIslandWork));
  CHECK(budget.solve() == tune::kLeastSolveWork);
}

void a_failed_attempt_leaves_room_for_shorter_ones() {
  hp::StepBudget budget;
  budget.begin_frame(8, 1);
  budget.begin_substep(8);
  int attempts = 0;
  for (; !budget.out() && attempts < 100; attempts++) {
    budget.begin_attempt();
    for (double taken = 0; !budget.attempt_out(taken); taken += 1e5) budget.spend(1e5);
  }
  CHECK(attempts >= 10);
}

}  // namespace

int main() {
  for (int substeps : {1, 4, 8, 32})
    for (int people : {1, 2}) a_frame_ends(substeps, people);
  what_a_substep_leaves_is_left_to_the_next();
  trouble_ends_no_other_island();
  a_failed_attempt_leaves_room_for_shorter_ones();
  return check::report("test_step_budget");
}
