// What came of a frame: poses, contacts, clearances, torques.
#include <nanobind/stl/optional.h>

#include <optional>

#include "bindings/stepper.h"

using namespace hp;

namespace hp {

void touch_rows(const std::vector<Touch>& touches, std::vector<double>& out) {
  for (const Touch& t : touches) {
    out.insert(out.end(), {(double)t.shape, (double)t.other_static, (double)t.other_shape});
    const double length = norm(t.normal);
    push(out, t.weight > 0 ? (1 / t.weight) * t.position : t.position);
    push(out, length > 0 ? (1 / length) * t.normal : t.normal);
    push(out, t.impulse);
  }
}

void soft_rows(const std::vector<SoftPoint>& points, std::vector<double>& out) {
  for (const SoftPoint& p : points) {
    out.insert(out.end(),
               {(double)p.layer_static, (double)p.layer_shape, (double)p.shape, (double)p.sample});
    push(out, p.position);
    push(out, p.normal);
    out.insert(out.end(), {p.depth, p.pressure, p.area});
  }
}

void inside_rows(const World& world, std::vector<double>& out) {
  for (const InitialOverlap& in : world.depenetration.overlaps())
    out.insert(out.end(),
               {(double)in.shape, (double)in.other_static, (double)in.other_shape, in.depth()});
  for (const Parting& p : world.parting.all())
    out.insert(out.end(), {(double)p.shape, -1, (double)p.other_shape, p.left});
}

void breach_rows(const std::vector<Breach>& breaches, std::vector<double>& out) {
  for (const Breach& k : breaches)
    out.insert(out.end(), {(double)k.pair.shape, (double)k.pair.other_static,
                           (double)k.pair.other_shape, k.depth});
}

}  // namespace hp

namespace {

// Distances (n,) of pairs of shapes (n, 2) at a pose [m], negative where they overlap.
auto pair_gaps(Stepper& s, Doubles qpos, Square pairs) {
  const System& system = s.system;
  const size_t n = system.world.shapes.size();
  need((int)qpos.shape(0) == system.model.nq, "pair_gaps: bad length of qpos");
  need(pairs.shape(0) == 0 || pairs.shape(1) == 2, "pair_gaps: pairs must be (n, 2)");
  std::vector<double> gaps;
  Poses p;  // of its own
  p.kin.resize(system.model);
  p.kin.update(system.model, qpos.data());
  system.world.start_poses(p);
  for (size_t k = 0; k < pairs.shape(0); k++) {
    const size_t i = (size_t)pairs.data()[2 * k], j = (size_t)pairs.data()[2 * k + 1];
    need(i < n && j < n, "pair_gaps: no such shapes");
    gaps.push_back(pair_gap(system.world, p, (int)i, (int)j));
  }
  return array(gaps);
}

// Of poses (T, nq): distances (T, shapes); `nearest` (T, shapes) is filled with statics.
auto clearances(Stepper& s, Square qpos, double range, std::optional<Indices> nearest) {
  const size_t poses = qpos.shape(0), n = s.system.world.shapes.size();
  need((int)qpos.shape(1) == s.system.model.nq, "clearances: bad shape of qpos");
  need(!nearest || (nearest->shape(0) == poses && nearest->shape(1) == n),
       "clearances: bad shape of nearest");
  std::vector<double> dist(poses * n);
  std::vector<int> others(nearest ? 0 : poses * n);
  {
    nb::gil_scoped_release release;
    s.clearances(qpos.data(), poses, range, dist.data(), nearest ? nearest->data() : others.data());
  }
  return array({poses, n}, dist);
}

auto clearance(Stepper& s) {
  nb::gil_scoped_release release;
  return s.clearance();
}

// By name, one row per sample; indices are whole numbers (n,), positions and normals (n, 3).
nb::dict soft_contacts(Stepper& s) {
  const std::vector<SoftPoint>& points = s.result().soft;
  const size_t n = points.size();
  std::vector<int> index[4];
  std::vector<double> position, normal, depth, pressure, area;
  for (const SoftPoint& p : points) {
    const int whole[] = {p.layer_static, p.layer_shape, p.shape, p.sample};
    for (int k = 0; k < 4; k++) index[k].push_back(whole[k]);
    push(position, p.position);
    push(normal, p.normal);
    depth.push_back(p.depth), pressure.push_back(p.pressure), area.push_back(p.area);
  }
  nb::dict out;
  const char* const names[] = {"layer_static", "layer_shape", "shape", "sample"};
  for (int k = 0; k < 4; k++) out[names[k]] = array(index[k]);
  out["position"] = array({n, 3}, position);
  out["normal"] = array({n, 3}, normal);
  out["depth"] = array(depth);
  out["pressure"] = array(pressure);
  out["area"] = array(area);
  return out;
}

nb::dict diagnostics(Stepper& s) {
  const Diagnostics& d = s.result().diagnostics;
  nb::dict out;
  out["planes"] = d.candidates;
  out["contacts"] = d.contacts;
  out["passes"] = d.passes;
  out["sweeps"] = d.sweeps;
  out["shortened"] = d.shortened;
  out["residual"] = d.residual;
  out["friction_residual"] = d.friction;
  out["friction_tolerances"] = d.friction_tolerances;
  out["lost_time"] = d.lost_time;
  return out;
}

}  // namespace

void bind_stepper_results(StepperClass& stepper) {
  stepper.def("qpos", [](Stepper& s) { return array(s.qpos()); })
      .def("qvel", [](Stepper& s) { return array(s.qvel()); })
      .def("clearance", &clearance)
      .def("clearances", &clearances, nb::arg("qpos"), nb::arg("range"),
           nb::arg("nearest") = nb::none())
      .def("pair_gaps", &pair_gaps)
      .def("touches",
           [](Stepper& s) {
             const std::vector<Touch>& touches = s.result().touches;
             std::vector<double> out;
             touch_rows(touches, out);
             return array({touches.size(), 12}, out);
           })
      // Samples under pressure at the end of the last frame, see soft_rows().
      .def("soft_contacts", &soft_contacts)
      .def("diagnostics", &diagnostics)
      // Bodies whose tree was touched in the substep before (a person's: in the frame).
      .def("disturbed",
           [](Stepper& s) {
             const std::vector<char>& disturbed = s.result().disturbed;
             return array(std::vector<double>(disturbed.begin(), disturbed.end()));
           })
      // Shapes that started inside something and are not out yet, see inside_rows().
      .def("inside",
           [](Stepper& s) {
             std::vector<double> out;
             inside_rows(s.system.world, out);
             return array({out.size() / 4, 4}, out);
           })
      // Overlaps of the last frame that should not be, see breach_rows().
      .def("breaches",
           [](Stepper& s) {
             std::vector<double> out;
             breach_rows(s.result().breaches, out);
             return array({out.size() / 4, 4}, out);
           })
      // Of the last frame (people, 2), see Stepper::footing.
      .def("footing",
           [](Stepper& s) {
             std::vector<double> out;
             s.footing(out);
             return array({out.size() / 2, 2}, out);
           })
      // Of the last frame (balls, 3), see Stepper::torques; (0, 3): none.
      .def("torques", [](Stepper& s) {
        std::vector<double> out;
        s.torques(out);
        return array({out.size() / 3, 3}, out);
      });
}
