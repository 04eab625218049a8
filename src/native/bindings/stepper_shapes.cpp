// What there is to collide: shapes of bodies, skins, static geometry, and what holds between pairs.
#include "assembly/shape_calls.h"
#include "assembly/soft_calls.h"
#include "bindings/stepper.h"

using namespace hp;
using namespace hp::assembly;
using namespace nb::literals;

void bind_stepper_shapes(StepperClass& stepper) {
  stepper.def("add_shape", &add_shape)
      .def("set_slack", &set_slack)
      .def("add_skin_shapes", &add_skin_shapes)
      .def("add_half_space", &add_half_space)
      .def("add_hull", &add_hull)
      .def("add_mesh", &add_mesh)
      .def("set_soft_static", &set_soft_static)
      .def("set_soft_shape", &set_soft_shape)
      .def("set_samples", &set_samples)
      .def("set_skin_samples", &set_skin_samples)
      .def("set_pairings", &set_pairings)
      .def("set_self_pairs", &set_self_pairs)
      // Poses (K, 3), (K, 4) of a kinematic body, K of them `fps` to the second; see Trajectory.
      .def("add_trajectory", &add_trajectory)
      .def("start_asleep", &Stepper::start_asleep);
}
