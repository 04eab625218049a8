// Resets, frames, snapshots. Frames run without the GIL.
#include <algorithm>
#include <chrono>

#include "bindings/recording.h"

using namespace hp;
using namespace nb::literals;

namespace {

auto frame(Stepper& s, Doubles targets, double dt, int n, bool record) {
  need((int)targets.shape(0) == target_count(s), "frame: bad length of targets");
  std::vector<double> poses;
  {
    nb::gil_scoped_release release;
    s.frame(targets.data(), dt, n, record ? &poses : nullptr);
  }
  const size_t nq = s.system.model.nq;
  return array({poses.size() / std::max<size_t>(nq, 1), nq}, poses);
}

// As many frames as fit into `seconds` of wall time, one at least. `stiffness`: firmness of every
// frame (frames, balls), or (0, 0) to leave it. Coordinates go to `qpos` (frames, nq).
nb::dict run(Stepper& s, Square targets, double dt, int n, bool record, double seconds,
             Square stiffness, Out qpos) {
  const Frames frames = Frames::of(s, targets, dt, n, record, stiffness, qpos);
  Recording recording;
  {
    nb::gil_scoped_release release;
    const auto begin = std::chrono::steady_clock::now();
    auto spent = [&]() {
      return std::chrono::duration<double>(std::chrono::steady_clock::now() - begin).count();
    };
    do frames.run(s, recording);
    while (recording.done < frames.count && spent() < seconds);
  }
  return recording.dict(s);
}

}  // namespace

void bind_stepper_frames(StepperClass& stepper) {
  stepper
      .def(
          "reset",
          [](Stepper& s, Doubles qpos, Doubles qvel, bool stand) {
            const Model& m = s.system.model;
            need((int)qpos.shape(0) == m.nq && (int)qvel.shape(0) == m.nv,
                 "reset: bad length of qpos or qvel");
            s.reset(qpos.data(), qvel.data(), stand);
          },
          "qpos"_a, "qvel"_a, "stand"_a = true)
      .def("frame", &frame)
      .def("run", &run)
      .def("set_velocity",
           [](Stepper& s, int body, Doubles six) {
             need(six.shape(0) == 6, "set_velocity: expected six numbers");
             s.set_velocity(body, six.data());
           })
      .def("adopt", [](Stepper& s, Stepper& old, Ints body,
                       Ints shape) { s.adopt(old, list<int>(body), list<int>(shape)); })
      .def("save", [](Stepper& s) { return array(s.save()); })
      .def("load", [](Stepper& s, Doubles state) { s.load(list<double>(state)); });
}
