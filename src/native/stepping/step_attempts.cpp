#include "stepping/step_attempts.h"

#include "stepping/sleeping.h"
#include "tuning.h"

namespace hp {

void StepAttempts::run(double h) {
  do {
    if (system_.prescribed == Prescribed::No)
      run_exits(h);
    else
      run_prescribed(h);
  } while (wake_touched(system_, data_));
}

void StepAttempts::run_prescribed(double h) {
  int tries = 0;
  do run_exits(h);
  while (!prescribed_.accept(system_, data_, tries++));
  prescribed_.release_jammed(system_.model);
}

void StepAttempts::run_exits(double h) {
  World& world = system_.world;
  if (!exit_.begin(world)) return contact_step_.run(h);
  // Where the budget has ended they come out no farther in this step.
  bool spent = data_.budget.frame_out();
  for (int k = 0; k < tuning::stepping::kExitTries && !spent; k++) {
    contact_step_.run(h);
    if (exit_.accept(system_, data_)) return;
    for (const InitialOverlap& in : world.depenetration.overlaps())
      spent |= data_.spent(data_.islands.of_tree(system_.tree(in.shape)));
  }
  exit_.give_up(world);
  contact_step_.run(h);
  exit_.finish(world);
}

}  // namespace hp
