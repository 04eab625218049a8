#include "math/dense.h"

#include <algorithm>
#include <cmath>

#include "math/simd.h"

namespace hp {

namespace {

// Columns first ... first + 2 among themselves, with what the rows of the pivots need of the rest;
// rows below keep their factors in these columns. False if a pivot is too small.
bool eliminate_three(double* a, int n, int first, double least_pivot, double* x, double* pivot[3]) {
  const int rest = first + 3;
  bool regular = true;
  auto row_at = [&](int r) { return a + (long)r * n; };
  for (int k = 0; k < 3; k++) {
    const int c = first + k;
    int best = c;
    for (int r = c + 1; r < n; r++)
      if (std::fabs(row_at(r)[c]) > std::fabs(row_at(best)[c])) best = r;
    pivot[k] = row_at(c);
    if (best != c) {
      std::swap_ranges(pivot[k] + first, pivot[k] + n, row_at(best) + first);
      std::swap(x[best], x[c]);
    }
    for (int l = 0; l < k; l++)
      add_scaled(pivot[k] + rest, -pivot[k][first + l], pivot[l] + rest, n - rest);
    regular &= std::fabs(pivot[k][c]) > least_pivot;
    const double inv = 1 / pivot[k][c];
    for (int r = c + 1; r < n; r++) {
      double* row = row_at(r);
      const double f = row[c] *= inv;
      for (int d = c + 1; d < rest; d++) row[d] -= f * pivot[k][d];
      x[r] -= f * x[c];
    }
  }
  return regular;
}

}  // namespace

bool solve_dense(double* a, int n, double least_pivot, double* x) {
  for (int first = 0; first < n; first += 3) {
    double* pivot[3];
    if (!eliminate_three(a, n, first, least_pivot, x, pivot)) return false;
    const int rest = first + 3;
    for (int r = rest; r < n; r++) {
      double* row = a + (long)r * n;
      add_scaled(row + rest, -row[first], pivot[0] + rest, -row[first + 1], pivot[1] + rest,
                 -row[first + 2], pivot[2] + rest, n - rest);
    }
  }
  for (int r = n - 1; r >= 0; r--) {
    const double* row = a + (long)r * n;
    double t = x[r];
    for (int d = r + 1; d < n; d++) t -= row[d] * x[d];
    x[r] = t / row[r];
  }
  return true;
}

void factor_cholesky(double* a, int n, const double* least) {
  for (int i = 0; i < n; i++) {
    double* row = a + (long)i * n;
    for (int j = 0; j <= i; j++) {
      const double* other = a + (long)j * n;
      double s = row[j];
      for (int c = 0; c < j; c++) s -= row[c] * other[c];
      row[j] = i == j ? std::sqrt(std::max(s, least[i])) : s / other[j];
    }
  }
}

void solve_cholesky(const double* L, int n, double* x) {
  for (int i = 0; i < n; i++) {
    double s = x[i];
    for (int c = 0; c < i; c++) s -= L[(long)i * n + c] * x[c];
    x[i] = s / L[(long)i * (n + 1)];
  }
  for (int i = n - 1; i >= 0; i--) {
    double s = x[i];
    for (int c = i + 1; c < n; c++) s -= L[(long)c * n + i] * x[c];
    x[i] = s / L[(long)i * (n + 1)];
  }
}

}  // namespace hp
