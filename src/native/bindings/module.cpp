// The native core: plain arrays in, plain arrays out; no simulation engine is linked.
#include "bindings/module.h"

NB_MODULE(_native, m) {
  m.doc() = "Native core of halfphysics.";
  // What a cache or a thread holds when the interpreter ends is no leak to tell a user of.
  nb::set_leak_warnings(false);
  bind_tuning(m);
  bind_physics(m);
  bind_skinning(m);
  bind_triangle_tree(m);
  bind_touching(m);
  bind_gaps(m);
  bind_part_balls(m);
  bind_wrench_spread(m);
  bind_coordinates(m);
  bind_world_file(m);
}
