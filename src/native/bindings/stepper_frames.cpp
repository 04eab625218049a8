// Resets, frames, another engine's world, snapshots. Frames run without the GIL.
#include <algorithm>
#include <chrono>

#include "bindings/stepper.h"

using namespace hp;

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

// What a run of frames is told to Python by.
struct Recording {
  std::vector<double> torques, torque_frames, qpos, poses, clearance, lost, touches, touch_count,
      numbers, inside, inside_count;
  size_t done = 0;

  void add(Stepper& s) {
    if (s.torques(torques)) torque_frames.push_back((double)done);
    qpos.insert(qpos.end(), s.qpos().begin(), s.qpos().end());
    clearance.push_back(s.clearance());
    const Diagnostics& g = s.result().diagnostics;
    lost.push_back(g.lost_time);
    numbers.insert(numbers.end(), {(double)g.candidates, (double)g.contacts, (double)g.passes,
                                   (double)g.sweeps, (double)g.shortened, g.residual});
    touch_count.push_back((double)s.result().touches.size());
    touch_rows(s.result().touches, touches);
    inside_count.push_back((double)s.system.world.depenetration.overlaps().size());
    inside_rows(s.system.world, inside);
    done++;
  }

  nb::dict dict(const Stepper& s) const {
    const size_t nq = s.system.model.nq;
    nb::dict d;
    d["qpos"] = array({done, nq}, qpos);
    d["clearance"] = array(clearance);
    d["lost_time"] = array(lost);
    // planes, contacts, passes, sweeps, shortened, residual
    d["diagnostics"] = array({done, 6}, numbers);
    d["touch_count"] = array(touch_count);
    d["touches"] = array({touches.size() / 12, 12}, touches);
    d["inside_count"] = array(inside_count);
    d["inside"] = array({inside.size() / 4, 4}, inside);
    d["torque_frames"] = array(torque_frames);
    d["torques"] = array({torque_frames.size(), (size_t)s.system.ball_count(), 3}, torques);
    d["substeps"] = array({poses.size() / std::max<size_t>(nq, 1), nq}, poses);
    return d;
  }
};

// As many frames as fit into `seconds` of wall time, one at least. `stiffness`: firmness of every
// frame (frames, balls), or (0, 0) to leave it.
nb::dict run(Stepper& s, Square targets, double dt, int n, bool record, double seconds,
             Square stiffness) {
  const int want = target_count(s);
  need((int)targets.shape(1) == want && targets.shape(0) > 0, "run: bad shape of targets");
  const size_t balls = stiffness.shape(0) ? stiffness.shape(1) : 0;
  need(
      balls == 0 || (stiffness.shape(0) == targets.shape(0) && (int)balls == s.system.ball_count()),
      "run: bad shape of stiffness");
  Recording recording;
  {
    nb::gil_scoped_release release;
    const auto begin = std::chrono::steady_clock::now();
    auto spent = [&]() {
      return std::chrono::duration<double>(std::chrono::steady_clock::now() - begin).count();
    };
    do {
      if (balls > 0) set_stiffness(s, stiffness.data() + recording.done * balls);
      s.frame(targets.data() + recording.done * want, dt, n, record ? &recording.poses : nullptr);
      recording.add(s);
    } while (recording.done < targets.shape(0) && spent() < seconds);
  }
  return recording.dict(s);
}

void substep_hosted(Stepper& s, int k, double h, Doubles qpos, Doubles qvel, Doubles v_free,
                    Doubles damping) {
  const size_t nq = s.system.model.nq, nv = s.system.model.nv;
  need(
      qpos.shape(0) == nq && qvel.shape(0) == nv && v_free.shape(0) == nv && damping.shape(0) == nv,
      "substep_hosted: bad length of qpos, qvel, v_free or damping");
  nb::gil_scoped_release release;
  s.substep_hosted(k, h, qpos.data(), qvel.data(), v_free.data(), damping.data());
}

}  // namespace

void bind_stepper_frames(StepperClass& stepper) {
  stepper
      .def("reset",
           [](Stepper& s, Doubles qpos, Doubles qvel) {
             const Model& m = s.system.model;
             need((int)qpos.shape(0) == m.nq && (int)qvel.shape(0) == m.nv,
                  "reset: bad length of qpos or qvel");
             s.reset(qpos.data(), qvel.data());
           })
      .def("frame", &frame)
      .def("run", &run)
      .def("set_velocity",
           [](Stepper& s, int body, Doubles six) {
             need(six.shape(0) == 6, "set_velocity: expected six numbers");
             s.set_velocity(body, six.data());
           })
      // In another engine's world: see Hosting.
      .def("begin_hosted",
           [](Stepper& s, Doubles targets, double dt) {
             need((int)targets.shape(0) == target_count(s), "begin_hosted: bad length of targets");
             s.begin_hosted(targets.data(), dt);
           })
      .def("substep_hosted", &substep_hosted)
      .def("end_hosted", &Stepper::end_hosted)
      .def("adopt", [](Stepper& s, Stepper& old, Ints body,
                       Ints shape) { s.adopt(old, list<int>(body), list<int>(shape)); })
      .def("save", [](Stepper& s) { return array(s.save()); })
      .def("load", [](Stepper& s, Doubles state) { s.load(list<double>(state)); });
}
