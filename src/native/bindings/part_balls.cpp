// Balls around groups of vertices (labels/part_balls.h), for labels/bounding_spheres.py.
#include "labels/part_balls.h"

#include <vector>

#include "bindings/arrays.h"

using namespace hp;

namespace {

nb::tuple part_balls(
    f64<nb::shape<-1, -1, 3>> positions, f64<nb::shape<-1, -1, 4>> quaternions, Ints joint,
    Ints group, Rows3 centre, Doubles radius,
    nb::ndarray<const uint8_t, nb::shape<-1, -1>, nb::c_contig, nb::device::cpu> wanted) {
  const size_t frames = positions.shape(0), joints = positions.shape(1), n = joint.shape(0);
  const size_t groups = wanted.shape(1);
  need(quaternions.shape(0) == frames && quaternions.shape(1) == joints,
       "positions and quaternions: expected one of every joint and frame");
  need(group.shape(0) == n && centre.shape(0) == n && radius.shape(0) == n,
       "joint, group, centre and radius: expected as many of each");
  need(wanted.shape(0) == frames, "wanted: expected a row of every frame");
  std::vector<CarriedBall> carried(n);
  for (size_t i = 0; i < n; i++) {
    carried[i] = {joint.data()[i], group.data()[i], load3(centre.data() + 3 * i), radius.data()[i]};
    need(carried[i].joint >= 0 && (size_t)carried[i].joint < joints, "joint: out of range");
    need(carried[i].group >= 0 && (size_t)carried[i].group < groups, "group: out of range");
  }
  std::vector<double> centres(frames * groups * 3), radii(frames * groups);
  {
    nb::gil_scoped_release release;
    for (size_t f = 0; f < frames; f++)
      group_balls(carried, positions.data() + f * joints * 3, quaternions.data() + f * joints * 4,
                  wanted.data() + f * groups, groups, centres.data() + f * groups * 3,
                  radii.data() + f * groups);
  }
  return nb::make_tuple(array({frames, groups, 3}, centres), array({frames, groups}, radii));
}

}  // namespace

void bind_part_balls(nb::module_& m) {
  m.def("part_balls", &part_balls, nb::arg("positions"), nb::arg("quaternions"), nb::arg("joint"),
        nb::arg("group"), nb::arg("centre"), nb::arg("radius"), nb::arg("wanted"),
        "Centres (T, groups, 3) and radii (T, groups) of balls around what joints carry of each "
        "group where it is wanted (T, groups); -inf: nothing.");
}
