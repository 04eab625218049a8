// Dense equations: the solution reproduces the right side; singular matrices are refused.
#include "math/dense.h"

#include <random>
#include <vector>

#include "check.h"

namespace {

void elimination_solves(int n, unsigned seed) {
  std::mt19937 draw(seed);
  std::normal_distribution<double> normal;
  std::vector<double> a(n * n), b(n);
  for (double& v : a) v = normal(draw);
  for (double& v : b) v = normal(draw);
  std::vector<double> factor = a, x = b;
  CHECK(hp::solve_dense(factor.data(), n, 1e-14, x.data()));
  for (int i = 0; i < n; i++) {
    double s = 0;
    for (int j = 0; j < n; j++) s += a[i * n + j] * x[j];
    CHECK_NEAR(s, b[i], 1e-9);  // condition numbers of random matrices are in the thousands
  }
}

// The first s rows symmetric and positive definite, of which the upper triangle alone is told; the others
// anything.
void mixed_solves(int n, int s, unsigned seed) {
  std::mt19937 draw(seed);
  std::normal_distribution<double> normal;
  std::vector<double> r(n * n), a(n * n, 0.0), b(n);
  for (double& v : r) v = normal(draw);
  for (double& v : b) v = normal(draw);
  for (int i = 0; i < n; i++)
    for (int j = 0; j < n; j++) {
      if (i >= s || j >= s) a[i * n + j] = r[i * n + j];
      for (int k = 0; k < s && i < s && j < s; k++)
        a[i * n + j] += r[i * n + k] * r[j * n + k] + (i == j);
    }
  std::vector<double> told = a, x = b;
  for (int i = 0; i < s; i++)
    for (int j = 0; j < i; j++) told[i * n + j] = 1e9;
  CHECK(hp::solve_mixed(told.data(), n, s, 1e-14, x.data()));
  for (int i = 0; i < n; i++) {
    double sum = 0;
    for (int j = 0; j < n; j++) sum += a[i * n + j] * x[j];
    CHECK_NEAR(sum, b[i], 1e-9);
  }
}

void indefinite_is_refused() {
  std::vector<double> a = {1, 2, 0, 0, 1, 0, 0, 0, 1}, x = {1, 1, 1};
  CHECK(!hp::solve_mixed(a.data(), 3, 2, 1e-14, x.data()));
  std::vector<double> b = {1, 2, 2, 4}, y = {1, 1};
  CHECK(!hp::solve_mixed(b.data(), 2, 0, 1e-14, y.data()));
}

void singular_is_refused() {
  std::vector<double> a = {1, 2, 3, 2, 4, 6, 0, 1, 1}, x = {1, 1, 1};
  CHECK(!hp::solve_dense(a.data(), 3, 1e-14, x.data()));
}

void cholesky_solves(int n, unsigned seed) {
  std::mt19937 draw(seed);
  std::normal_distribution<double> normal;
  std::vector<double> r(n * n), a(n * n, 0.0), b(n), least(n, 1e-14);
  for (double& v : r) v = normal(draw);
  for (double& v : b) v = normal(draw);
  for (int i = 0; i < n; i++)
    for (int j = 0; j < n; j++)
      for (int k = 0; k < n; k++) a[i * n + j] += r[i * n + k] * r[j * n + k] + (i == j);
  std::vector<double> L = a, x = b;
  hp::factor_cholesky(L.data(), n, least.data());
  hp::solve_cholesky(L.data(), n, x.data());
  for (int i = 0; i < n; i++) {
    double s = 0;
    for (int j = 0; j < n; j++) s += a[i * n + j] * x[j];
    CHECK_NEAR(s, b[i], 1e-11);
  }
}

}  // namespace

int main() {
  for (int n : {3, 6, 9, 30, 75}) elimination_solves(n, n), cholesky_solves(n, n);
  cholesky_solves(1, 1);
  for (int n : {1, 2, 3, 7, 30, 61})
    for (int s : {0, 1, n / 2, n - 1, n}) mixed_solves(n, s, 100 + n + s);
  indefinite_is_refused();
  singular_is_refused();
  return check::report("test_dense");
}
