#include "module.h"

void bind_skinning(nb::module_&) {}
