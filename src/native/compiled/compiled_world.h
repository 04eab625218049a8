// A world as it comes out of a world file: the stepper, and what its numbers stand for.
#pragma once
#include "compiled/labels.h"
#include "stepping/stepper.h"

namespace hp {

struct CompiledWorld {
  Stepper stepper;
  Labels labels;
  uint32_t checksum = 0;  // of the file
};

}  // namespace hp
