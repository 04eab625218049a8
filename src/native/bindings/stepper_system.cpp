// The stepper's model, settings, drives and joint forces. Settings are bound by name.
#include "assembly/limit_calls.h"
#include "assembly/system_calls.h"
#include "bindings/stepper.h"

using namespace hp;
using namespace hp::assembly;
using namespace nb::literals;

void bind_stepper_system(StepperClass& stepper) {
  stepper
      .def("set_model", &set_model, nb::kw_only(), "parent"_a, "jnt_first"_a, "jnt_count"_a,
           "dof_first"_a, "dof_count"_a, "pos"_a, "quat"_a, "ipos"_a, "iquat"_a, "mass"_a,
           "inertia"_a, "jnt_type"_a, "jnt_qpos"_a, "jnt_dof"_a, "jnt_body"_a, "jnt_pos"_a,
           "jnt_axis"_a, "qpos0"_a, "armature"_a)
      .def("set_joint_forces", &set_joint_forces, nb::kw_only(), "damping"_a, "stiffness"_a,
           "spring"_a, "limited"_a, "range"_a)
      // See DriveSettings.
      .def("set_drive", &set_drive, nb::kw_only(), "time_constant"_a, "recovery_rate"_a,
           "recover_root"_a, "root_speed"_a)
      // See ContactSettings and System.
      .def("set_contact", &set_contact, nb::kw_only(), "clearance"_a, "clearance_range"_a,
           "depenetration_speed"_a, "tolerance"_a, "max_sweeps"_a, "gravity"_a)
      // Forces and torques to compare with, see DriveSettings.
      .def("set_baselines", &set_baselines, nb::kw_only(), "internal_forces"_a, "joint_damping"_a,
           "torque_frequency"_a, "torque_damping"_a)
      // Before finish(): people's poses are set, see Prescribed.
      .def("set_prescribed", &set_prescribed)
      .def("finish", [](Stepper& s, std::vector<int> person_roots) { finish(s, person_roots); })
      // lambda of every ball joint of all people, in the model's order, roots (ignored) included.
      .def("set_stiffness",
           [](Stepper& s, Doubles lambda) {
             need((int)lambda.shape(0) == s.system.ball_count(), "set_stiffness: bad length");
             set_stiffness(s, lambda.data());
           })
      .def("stiffness",
           [](Stepper& s) {
             std::vector<double> out;
             for (const Drive& d : s.system.drives)
               out.insert(out.end(), d.stiffness().begin(), d.stiffness().end());
             return array(out);
           })
      .def("set_strength", &set_strength)
      .def("set_joint_ranges", &set_joint_ranges, "person"_a, nb::kw_only(), "axes"_a, "lower"_a,
           "upper"_a)
      // People who are blocked wait: see ReferenceClock. After finish().
      .def("set_waiting", &set_waiting)
      .def("set_footing", &set_footing, nb::kw_only(), "person"_a, "joints"_a, "soles"_a, "hands"_a,
           "body"_a, "weight"_a, "local"_a, "normal"_a)
      .def("person_qpos", [](Stepper& s, int p) { return s.system.drives.at(p).first_qpos(); })
      .def("person_qpos_count",
           [](Stepper& s, int p) { return s.system.drives.at(p).qpos_count(); });
}
