// The spread of a patch against closed forms and sums over its area.
#include "geometry/patch_spread.h"

#include <cmath>
#include <functional>

#include "check.h"

using hp::Convex;
using hp::PatchSpread;
using hp::PosedShape;
using hp::Vec3;

namespace {

constexpr double kExact = 1e-12;
constexpr double kSum = 1e-4;  // a sum over 1000 x 1000 cells
const Vec3 kUp{0, 0, 1};

// Of the face around points in a plane across n, as a prism has it.
double of_points(const std::vector<Vec3>& points, Vec3 n = kUp) {
  Convex prism;
  for (double h : {0.0, 0.1})
    for (Vec3 x : points) prism.vertices.push_back(x + h * n);
  prism.finish();
  PosedShape s;
  s.place(prism, {}, {});
  PatchSpread p(n);
  p.add_face(s, nullptr, 1e-9);
  return p.spread();
}

std::vector<Vec3> rectangle(double a, double b, Vec3 at = {}) {
  a *= 0.5, b *= 0.5;
  return {at + Vec3{a, b, 0}, at + Vec3{-a, b, 0}, at + Vec3{-a, -b, 0}, at + Vec3{a, -b, 0}};
}

// The mean of |x| where `inside`, of a square of half a width of 1.
double mean_distance(const std::function<bool(double, double)>& inside) {
  double sum = 0, count = 0;
  const int n = 1000;
  for (int i = 0; i < n; i++)
    for (int j = 0; j < n; j++) {
      const double x = (2 * i + 1.0) / n - 1, y = (2 * j + 1.0) / n - 1;
      if (inside(x, y)) sum += std::hypot(x, y), count++;
    }
  return sum / count;
}

PosedShape posed(const Convex& hull, Vec3 at) {
  PosedShape s;
  s.place(hull, {}, at);
  return s;
}

Convex box(double a, double b, double h) {
  Convex c;
  for (double z : {-0.5 * h, 0.5 * h})
    for (Vec3 x : rectangle(a, b)) c.vertices.push_back({x.x, x.y, z});
  c.finish();
  return c;
}

Convex cylinder(double radius, double h) {
  Convex c;
  c.vertices = {{0, 0, -0.5 * h}, {0, 0, 0.5 * h}};
  c.rim = radius;
  c.finish();
  return c;
}

void squares_edges_and_points() {
  // (sqrt 2 + log(1 + sqrt 2))/6 of the side, over its half diagonal.
  const double square = (std::sqrt(2.0) + std::log(1 + std::sqrt(2.0))) / 6 / std::sqrt(0.5);
  CHECK_NEAR(of_points(rectangle(1, 1)), square, kExact);
  CHECK_NEAR(of_points(rectangle(0.01, 0.01, {3, -2, 1})), square, 1e-10);
  const Vec3 tilted = (1 / std::sqrt(14.0)) * Vec3{3, 1, 2};
  Vec3 t, s;
  tangents(tilted, t, s);
  CHECK_NEAR(of_points({t + s, t - s, s - t, -s - t}, tilted), square, kExact);
  CHECK_NEAR(of_points({{0, 0, 0}, {0.3, 0, 0}}), 0.5, kExact);
  CHECK_NEAR(of_points({{0.1, 0, 0}}), 1, kExact);
}

void other_polygons() {
  const double mean = mean_distance([](double, double y) { return std::fabs(y) < 0.5; });
  CHECK_NEAR(of_points(rectangle(2, 1)), mean / std::hypot(1.0, 0.5), kSum);
  const double root = std::sqrt(3.0);
  const double triangle =
      mean_distance([&](double x, double y) { return x > -0.5 && x + root * std::fabs(y) < 1; });
  CHECK_NEAR(of_points({{1, 0, 0}, {-0.5, root / 2, 0}, {-0.5, -root / 2, 0}}), triangle, 1e-3);
}

void faces_of_shapes() {
  const Convex cube = box(0.2, 0.2, 0.1), disc = cylinder(0.1, 0.05), slab = box(2, 2, 0.1);
  const double square = of_points(rectangle(1, 1));
  const auto alone = [](const PosedShape& a, const PosedShape* b) {
    PatchSpread p(kUp);
    p.add_face(a, b, 1e-3);
    return p.spread();
  };
  const PosedShape floor = posed(slab, {0, 0, -0.05});
  const PosedShape on = posed(cube, {0.1, 0.2, 0.05}), round = posed(disc, {0.1, 0.2, 0.025});
  CHECK_NEAR(alone(on, nullptr), square, kExact);
  CHECK_NEAR(alone(on, &floor), square, kExact);
  CHECK_NEAR(alone(round, nullptr), 2.0 / 3, kExact);
  CHECK_NEAR(alone(round, &floor), 2.0 / 3, kExact);
  // Half over the edge: twice as long as wide.
  const PosedShape half = posed(cube, {1, 0, 0.05});
  CHECK_NEAR(alone(half, &floor), of_points(rectangle(2, 1)), 1e-9);
}

// Pieces that meet in a ring press as far from its centre as their corners are (0.859 and 0.85): they are not
// drawn into the hole.
void a_ring_of_pieces() {
  const int n = 48;
  const double inner = 0.7, outer = 1;
  std::vector<Convex> hulls(n);
  PatchSpread ring(kUp);
  for (int k = 0; k < n; k++) {
    for (double z : {0.0, 0.1})
      for (double r : {inner, outer})
        for (int e : {k, k + 1}) {
          const double angle = 2 * M_PI * e / n;
          hulls[k].vertices.push_back({r * std::cos(angle), r * std::sin(angle), z});
        }
    hulls[k].finish();
    ring.add_face(posed(hulls[k], {}), nullptr, 1e-3);
  }
  CHECK_NEAR(ring.spread(), 1, kExact);
}

}  // namespace

int main() {
  squares_edges_and_points();
  other_polygons();
  faces_of_shapes();
  a_ring_of_pieces();
  return check::report("patch_spread");
}
