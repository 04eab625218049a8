// Distances from a disc: of points, lines and planes by themselves, and as they end a search.
#include "geometry/disc_distance.h"

#include <random>

#include "check.h"
#include "geometry/gjk.h"

using hp::Vec3;

namespace {

// The same cases on every machine.
std::mt19937 seeded(unsigned seed) { return std::mt19937(seed); }

std::mt19937 random_bits = seeded(1);

double number(double least, double most) {
  return least + (most - least) * (double)(random_bits() >> 5) / (double)(1 << 27);
}

Vec3 point(double size) { return {number(-size, size), number(-size, size), number(-size, size)}; }

Vec3 direction() {
  for (;;) {
    const Vec3 p = point(1);
    if (norm2(p) > 0.01 && norm2(p) < 1) return (1 / norm(p)) * p;
  }
}

// The disc's point nearest to x.
Vec3 on_disc(Vec3 x, Vec3 axis, double rim) {
  const Vec3 q = x - dot(x, axis) * axis;
  return norm(q) > rim ? (rim / norm(q)) * q : q;
}

// What is found is mutual: the disc's point is the nearest to x, and no point of the hull of m is
// nearer to the disc by more than rounding.
void nearest_points_are_mutual() {
  int found = 0;
  for (int trial = 0; trial < 3000; trial++) {
    const int n = 1 + trial % 3;
    const Vec3 axis = direction(), away = number(0.05, 0.3) * direction();
    const double rim = 0.04;
    Vec3 m[3];
    for (Vec3& p : m) p = away + point(0.1);
    hp::DiscDistance got;
    if (!hp::disc_distance(m, n, axis, rim, got)) continue;
    found++;
    const Vec3 v = got.x - got.d;
    CHECK_NEAR(norm(got.d - on_disc(got.x, axis, rim)), 0, 1e-9);
    Vec3 sum;
    for (int k = 0; k < n; k++) sum += got.l[k] * m[k], CHECK(got.l[k] >= 0);
    CHECK_NEAR(norm(sum - got.x), 0, 1e-12);
    for (int k = 0; k < n; k++) CHECK(dot(v, m[k]) > dot(v, got.x) - 1e-9 || n == 1);
  }
  CHECK(found > 1000);
}

struct Box {
  double x[8], y[8], z[8];
  Box(Vec3 at, Vec3 half) {
    for (int k = 0; k < 8; k++) {
      x[k] = at.x + (k & 1 ? half.x : -half.x);
      y[k] = at.y + (k & 2 ? half.y : -half.y);
      z[k] = at.z + (k & 4 ? half.z : -half.z);
    }
  }
  hp::Support support() const { return hp::Support{{x, y, z, 8}}; }
};

// The direction between the nearest points separates the two by the distance that is returned,
// whichever of the two has the disc, with and without a hint from a place nearby.
void a_cylinder_and_a_box() {
  for (int trial = 0; trial < 3000; trial++) {
    const Vec3 axis = direction(), at = number(0.12, 0.3) * direction();
    const Vec3 half = 0.5 * (point(0.06) + Vec3{0.07, 0.07, 0.07});
    const Vec3 ends[2] = {-0.05 * axis, 0.05 * axis};
    const double x[2] = {ends[0].x, ends[1].x}, y[2] = {ends[0].y, ends[1].y},
                 z[2] = {ends[0].z, ends[1].z};
    const hp::Support cylinder{{x, y, z, 2}, axis, 0.035};
    hp::Hint hint;
    Vec3 pa, pb;
    for (int step = 0; step < 3; step++) {
      const Box box(at + point(0.002), half);
      const double plain = gjk(box.support(), cylinder, at, pa, pb);
      const double hinted = gjk(box.support(), cylinder, at, pa, pb, 1e300, &hint);
      CHECK_NEAR(hinted, plain, 1e-11);
      const double turned = gjk(cylinder, box.support(), -at, pb, pa);
      CHECK_NEAR(turned, plain, 1e-11);
      if (plain < 1e-6) continue;
      CHECK_NEAR(norm(pa - pb), plain, 1e-11);
      const Vec3 n = (1 / plain) * (pa - pb);
      const double apart = dot(n, box.support().farthest(-n)) - dot(n, cylinder.farthest(n));
      CHECK_NEAR(apart, plain, 1e-10);
      const double beyond = 0.5 * plain;
      const double bound = gjk(box.support(), cylinder, at, pa, pb, beyond, &hint);
      CHECK(bound > beyond && bound <= plain + 1e-11);
      CHECK_NEAR(norm(pa - pb), 1, 1e-9);
    }
  }
}

}  // namespace

int main() {
  nearest_points_are_mutual();
  a_cylinder_and_a_box();
  return check::report("disc_distance");
}
