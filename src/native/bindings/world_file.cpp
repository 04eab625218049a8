// The reader of world files, for tests and fuzzing: what a program without Python would get.
#include <nanobind/stl/string.h>

#include "bindings/module.h"
#include "compiled/replay.h"

using namespace hp;

namespace {

// Reads a world and holds its start for so many frames of 1/30 s; the coordinates after them (nq,). Throws
// std::invalid_argument where the bytes are no world file or describe no world.
nb::ndarray<nb::numpy, double> run_world(nb::bytes bytes, int frames) {
  auto qpos = std::make_unique<std::vector<double>>();
  {
    nb::gil_scoped_release release;
    const auto world = read_world(bytes.data(), bytes.size());
    Stepper& stepper = world->stepper;
    std::vector<double> start = world->labels.start_qpos, targets;
    for (const Drive& d : stepper.system.drives) {
      const double* own = &stepper.system.model.qpos0[d.first_qpos()];
      std::copy_n(own, d.qpos_count(), &start[d.first_qpos()]);
      targets.insert(targets.end(), own, own + d.qpos_count());
    }
    stepper.reset(start.data(), world->labels.start_qvel.data());
    for (int i = 0; i < frames; i++)
      stepper.frame(targets.data(), 1.0 / 30, world->labels.substeps_for(1.0 / 30));
    *qpos = stepper.qpos();
  }
  const size_t count = qpos->size();
  double* data = qpos->data();
  nb::capsule owner(qpos.release(),
                    [](void* p) noexcept { delete static_cast<std::vector<double>*>(p); });
  return {data, {count}, owner};
}

}  // namespace

void bind_world_file(nb::module_& m) {
  m.def("run_world", &run_world, nb::arg("bytes"), nb::arg("frames"));
}
