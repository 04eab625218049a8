// Checks of the core's own tests: prints each failure with its place; main() returns their number.
#pragma once
#include <cmath>
#include <cstdio>

namespace check {

inline int failures = 0;
inline int checks = 0;

inline void that(bool ok, const char* what, const char* file, int line) {
  checks++;
  if (ok) return;
  failures++;
  std::fprintf(stderr, "%s:%d: failed: %s\n", file, line, what);
}

inline void near(double found, double expected, double tolerance, const char* what,
                 const char* file, int line) {
  checks++;
  if (std::fabs(found - expected) <= tolerance) return;  // false for NaN
  failures++;
  std::fprintf(stderr, "%s:%d: failed: %s is %.17g, expected %.17g within %g\n", file, line, what,
               found, expected, tolerance);
}

// The exit code of a test program.
inline int report(const char* name) {
  std::printf("%s: %d checks, %d failed\n", name, checks, failures);
  return failures == 0 && checks > 0 ? 0 : 1;
}

}  // namespace check

#define CHECK(condition) check::that((condition), #condition, __FILE__, __LINE__)
#define CHECK_NEAR(found, expected, tolerance) \
  check::near((found), (expected), (tolerance), #found, __FILE__, __LINE__)
