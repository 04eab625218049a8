#include "module.h"

void bind_raster(nb::module_&) {}
