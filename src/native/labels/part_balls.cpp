#include "labels/part_balls.h"

#include <algorithm>
#include <cmath>
#include <limits>

namespace hp {

void group_balls(const std::vector<CarriedBall>& carried, const double* position,
                 const double* quaternion, const unsigned char* wanted, size_t groups,
                 double* centre, double* radius) {
  constexpr double inf = std::numeric_limits<double>::infinity();
  std::vector<Vec3> at(carried.size()), low(groups, Vec3{inf, inf, inf}),
      high(groups, Vec3{-inf, -inf, -inf});
  Mat3 turn;
  int joint = -1;
  for (size_t i = 0; i < carried.size(); i++) {
    const CarriedBall& c = carried[i];
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
    const CarriedBall& c = carried[i];
    if (!wanted[c.group]) continue;
    radius[c.group] =
        std::max(radius[c.group], norm(at[i] - load3(centre + 3 * c.group)) + c.radius);
  }
}

}  // namespace hp
