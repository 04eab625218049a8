#include "math/dense.h"

#include <algorithm>
#include <cmath>
#include <vector>

#include "math/simd.h"

namespace hp {

namespace {

// Three columns of a matrix, each in a row, from the diagonal on down.
struct Panel {
  std::vector<double> column[3];

  void load(const double* a, int n, int first) {
    for (int k = 0; k < 3; k++) column[k].resize(n);
    for (int r = first; r < n; r++)
      for (int k = 0; k < 3; k++) column[k][r] = a[(long)r * n + first + k];
  }
};

// Index of the entry of the largest size, from `first` on.
int largest(const double* v, int first, int n) {
  int best = first;
  for (int r = first + 1; r < n; r++)
    if (std::fabs(v[r]) > std::fabs(v[best])) best = r;
  return best;
}

// Columns first ... first + 2 among themselves, with what the rows of the pivots need of the rest; the
// panel has the factors of the rows below. False if a pivot is too small.
bool eliminate_three(double* a, int n, int first, double least_pivot, double* x, Panel& panel) {
  const int rest = first + 3;
  bool regular = true;
  panel.load(a, n, first);
  for (int k = 0; k < 3; k++) {
    const int c = first + k;
    double *own = panel.column[k].data(), *row = a + (long)c * n;
    const int best = largest(own, c, n);
    if (best != c) {
      std::swap_ranges(row + rest, row + n, a + (long)best * n + rest);
      for (std::vector<double>& column : panel.column) std::swap(column[best], column[c]);
      std::swap(x[best], x[c]);
    }
    for (int l = 0; l < k; l++)
      add_scaled(row + rest, -panel.column[l][c], a + (long)(first + l) * n + rest, n - rest);
    regular &= std::fabs(own[c]) > least_pivot;
    const double inv = 1 / own[c];
    for (int d = k; d < 3; d++) row[first + d] = panel.column[d][c];
    for (int r = c + 1; r < n; r++) own[r] *= inv;
    for (int d = k + 1; d < 3; d++)
      add_scaled(&panel.column[d][c + 1], -panel.column[d][c], own + c + 1, n - c - 1);
    add_scaled(x + c + 1, -x[c], own + c + 1, n - c - 1);
  }
  return regular;
}

}  // namespace

bool solve_dense(double* a, int n, double least_pivot, double* x) {
  static thread_local Panel panel;
  for (int first = 0; first < n; first += 3) {
    if (!eliminate_three(a, n, first, least_pivot, x, panel)) return false;
    const int rest = first + 3;
    const double* pivot = a + (long)first * n + rest;
    subtract_three(a + (long)rest * n + rest, n, n - rest, &panel.column[0][first] + 3,
                   &panel.column[1][first] + 3, &panel.column[2][first] + 3, pivot, pivot + n,
                   pivot + 2 * n);
  }
  for (int r = n - 1; r >= 0; r--) {
    const double* row = a + (long)r * n;
    x[r] = (x[r] - inner(row + r + 1, x + r + 1, n - r - 1)) / row[r];
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
