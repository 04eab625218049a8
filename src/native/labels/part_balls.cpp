// Balls around groups of a skin's vertices in every frame (labels/part_balls.py).
#include <algorithm>
#include <cmath>
#include <limits>
#include <vector>

#include "bindings/arrays.h"

using namespace hp;

namespace {

// What a joint carries of a group: the ball around it, in the joint's frame.
struct Carried {
  int joint, group;
  Vec3 centre;
  double radius;
};

constexpr double inf = std::numeric_limits<double>::infinity();

void balls_of(const std::vector<Carried>& carried, const double* position,
              const double* quaternion, const unsigned char* wanted, size_t groups,
              double* centre, double* radius) {
  std::vector<Vec3> at(carried.size()), low(groups, Vec3{inf, inf, inf}),
      high(groups, Vec3{-inf, -inf, -inf});
  Mat3 turn;
  int joint = -1;
  for (size_t i = 0; i < carried.size(); i++) {
    const Carried& c = carried[i];
    if (!wanted[c.group]) continue;
    if (c.joint != joint) turn = to_matrix(load4(quaternion + 4 * (joint = c.joint)));
    at[i] = turn * c.centre + load3(position + 3 * joint);
    for (int k = 0; k < 3; k++) {
      low[c.group][k] = std::min(low[c.group][k], at[i][k]);
      high[c.group][k] = std::max(high[c.group][k], at[i][k]);
    }
  }
  for (size_t g = 0; g < groups; g++) {
    radius[g] = -inf;
    store3(centre + 3 * g, low[g].x <= high[g].x ? 0.5 * (low[g] + high[g]) : Vec3{});
  }
  for (size_t i = 0; i < carried.size(); i++) {
    const Carried& c = carried[i];
    if (!wanted[c.group]) continue;
    radius[c.group] =
        std::max(radius[c.group], norm(at[i] - load3(centre + 3 * c.group)) + c.radius);
  }
}

nb::tuple part_balls(f64<nb::shape<-1, -1, 3>> positions, f64<nb::shape<-1, -1, 4>> quaternions,
                     Ints joint, Ints group, Rows3 centre, Doubles radius,
                     nb::ndarray<const uint8_t, nb::shape<-1, -1>, nb::c_contig, nb::device::cpu>
                         wanted) {
  const size_t frames = positions.shape(0), joints = positions.shape(1), n = joint.shape(0);
  const size_t groups = wanted.shape(1);
  need(quaternions.shape(0) == frames && quaternions.shape(1) == joints,
       "positions and quaternions: expected one of every joint and frame");
  need(group.shape(0) == n && centre.shape(0) == n && radius.shape(0) == n,
       "joint, group, centre and radius: expected as many of each");
  need(wanted.shape(0) == frames, "wanted: expected a row of every frame");
  std::vector<Carried> carried(n);
  for (size_t i = 0; i < n; i++) {
    carried[i] = {joint.data()[i], group.data()[i], load3(centre.data() + 3 * i), radius.data()[i]};
    need(carried[i].joint >= 0 && (size_t)carried[i].joint < joints, "joint: out of range");
    need(carried[i].group >= 0 && (size_t)carried[i].group < groups, "group: out of range");
  }
  std::vector<double> centres(frames * groups * 3), radii(frames * groups);
  {
    nb::gil_scoped_release release;
    for (size_t f = 0; f < frames; f++)
      balls_of(carried, positions.data() + f * joints * 3, quaternions.data() + f * joints * 4,
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
