// Balls around the skin of each part in every frame (labels/part_balls.py).
#include <algorithm>
#include <cmath>
#include <limits>
#include <vector>

#include "bind_arrays.h"

using namespace hp;

namespace {

// What a joint carries of a part: the ball around it, in the joint's frame.
struct Carried {
  int joint, part;
  Vec3 centre;
  double radius;
};

void balls_of(const std::vector<Carried>& carried, const double* position,
              const double* quaternion, size_t parts, double* centre, double* radius) {
  constexpr double inf = std::numeric_limits<double>::infinity();
  std::vector<Vec3> at(carried.size()), low(parts, Vec3{inf, inf, inf}),
      high(parts, Vec3{-inf, -inf, -inf});
  Mat3 turn;
  int joint = -1;
  for (size_t i = 0; i < carried.size(); i++) {
    const Carried& c = carried[i];
    if (c.joint != joint) turn = to_matrix(load4(quaternion + 4 * (joint = c.joint)));
    at[i] = turn * c.centre + load3(position + 3 * joint);
    for (int k = 0; k < 3; k++) {
      low[c.part][k] = std::min(low[c.part][k], at[i][k]);
      high[c.part][k] = std::max(high[c.part][k], at[i][k]);
    }
  }
  for (size_t p = 0; p < parts; p++) {
    radius[p] = -inf;
    store3(centre + 3 * p, low[p].x <= high[p].x ? 0.5 * (low[p] + high[p]) : Vec3{});
  }
  for (size_t i = 0; i < carried.size(); i++) {
    const Carried& c = carried[i];
    radius[c.part] =
        std::max(radius[c.part], norm(at[i] - load3(centre + 3 * c.part)) + c.radius);
  }
}

nb::tuple part_balls(f64<nb::shape<-1, -1, 3>> positions, f64<nb::shape<-1, -1, 4>> quaternions,
                     Ints joint, Ints part, Rows3 centre, Doubles radius) {
  const size_t frames = positions.shape(0), joints = positions.shape(1), n = joint.shape(0);
  need(quaternions.shape(0) == frames && quaternions.shape(1) == joints,
       "positions and quaternions: expected one of every joint and frame");
  need(part.shape(0) == n && centre.shape(0) == n && radius.shape(0) == n,
       "joint, part, centre and radius: expected as many of each");
  std::vector<Carried> carried(n);
  for (size_t i = 0; i < n; i++) {
    carried[i] = {joint.data()[i], part.data()[i], load3(centre.data() + 3 * i), radius.data()[i]};
    for (const int index : {carried[i].joint, carried[i].part})
      need(index >= 0 && (size_t)index < joints, "joint and part: out of range");
  }
  std::vector<double> centres(frames * joints * 3), radii(frames * joints);
  {
    nb::gil_scoped_release release;
    for (size_t f = 0; f < frames; f++)
      balls_of(carried, positions.data() + f * joints * 3, quaternions.data() + f * joints * 4,
               joints, centres.data() + f * joints * 3, radii.data() + f * joints);
  }
  return nb::make_tuple(array({frames, joints, 3}, centres), array({frames, joints}, radii));
}

}  // namespace

void bind_part_balls(nb::module_& m) {
  m.def("part_balls", &part_balls, nb::arg("positions"), nb::arg("quaternions"), nb::arg("joint"),
        nb::arg("part"), nb::arg("centre"), nb::arg("radius"),
        "Centres (T, J, 3) and radii (T, J) of balls around what joints carry of each part; -inf: "
        "nothing.");
}
