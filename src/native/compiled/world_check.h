// Whether what a world file said can be simulated: indices within their arrays, sizes that fit each other, values within
// their ranges. Whatever passes is safe to step. All throw std::invalid_argument.
#pragma once
#include "compiled/compiled_world.h"

namespace hp {

// Shapes, statics, pairs and settings, before System::finish.
void check_before_finish(const System& system);
// Everything, names and places included, at the end.
void check_world(const CompiledWorld& world);

}  // namespace hp
