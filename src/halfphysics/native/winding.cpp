#include "module.h"

void bind_winding(nb::module_&) {}
