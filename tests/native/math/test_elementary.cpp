// Elementary functions against the C library's of long double: errors in units in the last place, and special values.
#include "math/elementary.h"

#include <cmath>
#include <cstdio>
#include <random>

#include "check.h"

namespace {

namespace el = hp::elementary;

// The error of `found` in units in the last place of the true value.
double ulps(double found, long double truth) {
  const double near = (double)truth;
  const double unit = std::nextafter(std::fabs(near), HUGE_VAL) - std::fabs(near);
  return (double)(std::fabs((long double)found - truth) / (long double)unit);
}

std::mt19937_64 seeded(unsigned seed) { return std::mt19937_64(seed); }

template <typename Ours, typename Theirs, typename Draw>
double worst(Ours ours, Theirs theirs, Draw draw, const char* name) {
  std::mt19937_64 random = seeded(7);
  double most = 0, at = 0;
  for (int i = 0; i < 200'000; i++) {
    const double x = draw(random);
    const double error = ulps(ours(x), theirs((long double)x));
    if (error > most) most = error, at = x;
  }
  std::printf("%s: %.3f ulp at %a\n", name, most, at);
  return most;
}

auto between(double a, double b) { return std::uniform_real_distribution<double>(a, b); }
// Of any size down to 1e-300.
double small(std::mt19937_64& random) {
  const double size = std::pow(10.0, between(-300, 0)(random));
  return random() & 1 ? size : -size;
}

void errors() {
  auto sin = [](long double x) { return std::sin(x); };
  auto cos = [](long double x) { return std::cos(x); };
  auto tan = [](long double x) { return std::tan(x); };
  auto atan = [](long double x) { return std::atan(x); };
  auto asin = [](long double x) { return std::asin(x); };
  auto acos = [](long double x) { return std::acos(x); };
  auto exp = [](long double x) { return std::exp(x); };
  auto log = [](long double x) { return std::log(x); };
  CHECK(worst(el::sin, sin, between(-7, 7), "sin") < 1);
  CHECK(worst(el::sin, sin, between(-9e4, 9e4), "sin of large") < 1);
  CHECK(worst(el::sin, sin, small, "sin of small") < 1);
  CHECK(worst(el::cos, cos, between(-7, 7), "cos") < 1);
  CHECK(worst(el::cos, cos, between(-9e4, 9e4), "cos of large") < 1);
  CHECK(worst(el::tan, tan, between(-1.6, 1.6), "tan") < 3);
  CHECK(worst(el::atan, atan, between(-3, 3), "atan") < 1.2);
  CHECK(worst(el::atan, atan, small, "atan of small") < 1.2);
  CHECK(worst(el::atan, atan, between(-1e4, 1e4), "atan of large") < 1);
  CHECK(worst(el::asin, asin, between(-1, 1), "asin") < 3);
  CHECK(worst(el::acos, acos, between(-1, 1), "acos") < 3);
  CHECK(worst(el::exp, exp, between(-30, 30), "exp") < 1);
  CHECK(worst(el::exp, exp, between(-700, 700), "exp of large") < 1);
  CHECK(worst(el::log, log, between(0.3, 3), "log") < 1);
  CHECK(worst(el::log, log, between(0, 1e6), "log of large") < 1);
  std::mt19937_64 random = seeded(3);
  double most = 0;
  for (int i = 0; i < 200'000; i++) {
    const double y = between(-2, 2)(random), x = between(-2, 2)(random);
    most = std::max(most, ulps(el::atan2(y, x), std::atan2((long double)y, (long double)x)));
  }
  std::printf("atan2: %.3f ulp\n", most);
  CHECK(most < 1.2);
}

bool same(double a, double b) {
  return std::isnan(a) ? std::isnan(b) : a == b && std::signbit(a) == std::signbit(b);
}

void special_values() {
  const double values[] = {0.0, -0.0, 1.0, -1.0, HUGE_VAL, -HUGE_VAL, NAN, 2.5, -2.5};
  for (double x : values) {
    CHECK(same(el::exp(x), std::exp(x)) || std::fabs(x) == 2.5 || std::fabs(x) == 1);
    CHECK(same(std::sin(x), el::sin(x)) || std::isfinite(x));
    CHECK(x != 0 || same(el::sin(x), x));
    CHECK(x != 0 || same(el::atan(x), x));
    for (double y : values) {
      const double ours = el::atan2(y, x), theirs = std::atan2(y, x);
      CHECK(same(ours, theirs) || std::fabs(ours - theirs) < 1e-15);
      CHECK(std::isnan(theirs) || std::signbit(ours) == std::signbit(theirs));
    }
  }
  CHECK(same(el::log(0), -HUGE_VAL));
  CHECK(std::isnan(el::log(-1)));
  CHECK(same(el::exp(-1e9), 0));
  CHECK(same(el::exp(1e9), HUGE_VAL));
  CHECK(el::exp(0) == 1 && el::log(1) == 0 && el::cos(0) == 1);
  CHECK(std::isnan(el::asin(1.5)) && std::isnan(el::acos(-1.5)));
  CHECK(el::acos(1) == 0 && el::asin(1) == el::atan2(1, 0));
  CHECK(el::pow(0, 0.5) == 0 && el::pow(1, 7) == 1 && el::pow(5, 0) == 1);
  CHECK(std::fabs(el::pow(0.3, 0.7) - std::pow(0.3, 0.7)) < 1e-15);
  CHECK(el::hypot(3, 4) == 5);
}

}  // namespace

int main() {
  errors();
  special_values();
  return check::report("test_elementary");
}
