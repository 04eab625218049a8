#include "module.h"

void bind_physics(nb::module_&) {}
