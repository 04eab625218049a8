// The area in which two faces overlap, against closed forms.
#include "geometry/contact_manifold.h"

#include <algorithm>
#include <cmath>

#include "check.h"

using hp::Convex;
using hp::PosedShape;
using hp::Vec3;

namespace {

constexpr double kExact = 1e-12, kNear = 2e-3;  // [m]; the second: how near a face is
constexpr int kMost = 8;
const Vec3 kUp{0, 0, 1};

PosedShape posed(const Convex& hull, Vec3 at) {
  PosedShape s;
  s.place(hull, {}, at);
  return s;
}

Convex prism(const std::vector<Vec3>& corners, double h, double slope = 0) {
  Convex c;
  for (double z : {-0.5 * h, 0.5 * h})
    for (Vec3 x : corners) c.vertices.push_back({x.x, x.y, z + slope * x.x});
  c.finish();
  return c;
}

Convex box(double a, double b, double h) {
  return prism({{a / 2, b / 2, 0}, {-a / 2, b / 2, 0}, {-a / 2, -b / 2, 0}, {a / 2, -b / 2, 0}}, h);
}

Convex disc(int sides, double radius, double h, double slope = 0) {
  std::vector<Vec3> corners;
  for (int k = 0; k < sides; k++)
    corners.push_back(
        {radius * std::cos(2 * M_PI * k / sides), radius * std::sin(2 * M_PI * k / sides), 0});
  return prism(corners, h, slope);
}

void two_boxes_meet_in_the_rectangle_that_they_share() {
  const Convex upper = box(0.4, 0.2, 0.1), lower = box(0.4, 0.4, 0.1);
  const PosedShape a = posed(upper, {0.1, 0.15, 0.0505}), b = posed(lower, {0, 0, -0.05});
  Vec3 pa[kMost], pb[kMost];
  const int n = hp::face_manifold(a, b, kUp, kNear, kMost, pa, pb);
  CHECK(n == 4);
  for (int k = 0; k < n; k++) {
    CHECK(std::fabs(pa[k].x + 0.1) < kExact || std::fabs(pa[k].x - 0.2) < kExact);
    CHECK(std::fabs(pa[k].y - 0.05) < kExact || std::fabs(pa[k].y - 0.2) < kExact);
    CHECK_NEAR(pa[k].x, pb[k].x, kExact);
    CHECK_NEAR(pa[k].y, pb[k].y, kExact);
    CHECK_NEAR(pa[k].z, 0.0005, kExact);
    CHECK_NEAR(pb[k].z, 0, kExact);
  }
}

// Both ends of a short edge are near, at one place: it is as high as the lower one.
void an_edge_along_the_normal_has_the_height_of_its_lower_end() {
  Convex upright;
  upright.vertices = {{0, 0, 0}, {0, 0, 0.0015}, {0.05, 0, 0.05}, {0, 0.05, 0.05}};
  upright.finish();
  const Convex table = box(1, 1, 0.1);
  const PosedShape a = posed(upright, {0.1, 0.05, 0.0005}), b = posed(table, {0, 0, -0.05});
  Vec3 pa[kMost], pb[kMost];
  const int n = hp::face_manifold(a, b, kUp, kNear, kMost, pa, pb);
  CHECK(n > 0);
  for (int k = 0; k < n; k++) {
    CHECK_NEAR(pa[k].z, 0.0005, kExact);
    CHECK_NEAR(pb[k].z, 0, kExact);
  }
}

// Of a disc on another one the points lie on the rim of what both share, at the height of their planes.
void of_many_corners_some_are_enough(int sides) {
  const double radius = 0.1, aside = 0.06, slope = 0.002;
  const Convex upper = disc(sides, radius, 0.02, slope), lower = disc(sides, radius, 0.02);
  const PosedShape a = posed(upper, {aside, 0, 0.0105}), b = posed(lower, {0, 0, -0.01});
  Vec3 pa[kMost], pb[kMost];
  const int n = hp::face_manifold(a, b, kUp, kNear, kMost, pa, pb);
  CHECK(n >= 4);
  const double left_out = radius * (1 - std::cos(M_PI / std::min(sides, 64)));
  double highest = 0;
  for (int k = 0; k < n; k++) {
    const double to_a = std::hypot(pa[k].x - aside, pa[k].y), to_b = std::hypot(pa[k].x, pa[k].y);
    CHECK(std::max(to_a, to_b) < radius + kExact);
    CHECK(std::max(to_a, to_b) > radius - left_out);
    CHECK_NEAR(pa[k].z, 0.0005 + slope * (pa[k].x - aside), kExact);
    CHECK_NEAR(pb[k].z, 0, kExact);
    highest = std::max(highest, std::fabs(pa[k].y));
  }
  // Where the two rims cross.
  CHECK_NEAR(highest, std::sqrt(radius * radius - aside * aside / 4), 0.05 * radius);
}

// Lone corners are kept, however many a round end has.
void a_plank_with_a_round_end_keeps_its_square_one() {
  std::vector<Vec3> corners{{-0.3, 0.1, 0}, {-0.3, -0.1, 0}};
  for (int k = 0; k <= 200; k++) {
    const double angle = M_PI * (k / 200.0 - 0.5);
    corners.push_back({0.3 + 0.1 * std::cos(angle), 0.1 * std::sin(angle), 0});
  }
  const Convex plank = prism(corners, 0.02), cube = box(0.1, 0.4, 0.02);
  const PosedShape a = posed(cube, {-0.3, 0, 0.0105}), b = posed(plank, {0, 0, -0.01});
  Vec3 pa[kMost], pb[kMost];
  const int n = hp::face_manifold(a, b, kUp, kNear, kMost, pa, pb);
  CHECK(n == 4);
  for (int k = 0; k < n; k++) {
    CHECK(std::fabs(pb[k].x + 0.3) < kExact || std::fabs(pb[k].x + 0.25) < kExact);
    CHECK_NEAR(std::fabs(pb[k].y), 0.1, kExact);
  }
}

}  // namespace

int main() {
  two_boxes_meet_in_the_rectangle_that_they_share();
  an_edge_along_the_normal_has_the_height_of_its_lower_end();
  for (int sides : {16, 128, 129, 1000, 4001}) of_many_corners_some_are_enough(sides);
  a_plank_with_a_round_end_keeps_its_square_one();
  return check::report("contact_manifold");
}
