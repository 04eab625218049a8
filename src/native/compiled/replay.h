// World files to worlds: makes the calls of a file (compiled/world_file.h), each the function of assembly/ of that name.
#pragma once
#include <memory>

#include "compiled/compiled_world.h"

namespace hp {

// Throws std::invalid_argument where the bytes are no world file, or describe no world.
std::unique_ptr<CompiledWorld> read_world(const void* bytes, size_t size);

}  // namespace hp
