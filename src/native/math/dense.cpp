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
    subtract_three(a + (long)rest * n + rest, n, n - rest, n - rest, &panel.column[0][first] + 3,
                   &panel.column[1][first] + 3, &panel.column[2][first] + 3, pivot, pivot + n,
                   pivot + 2 * n);
  }
  for (int r = n - 1; r >= 0; r--) {
    const double* row = a + (long)r * n;
    x[r] = (x[r] - inner(row + r + 1, x + r + 1, n - r - 1)) / row[r];
  }
  return true;
}

namespace {

// Rows first ... first + count - 1 of the symmetric part among themselves. False if a pivot is too small.
bool eliminate_symmetric(double* a, int n, int first, int count, double least_pivot, double* x) {
  for (int c = first; c < first + count; c++) {
    double* row = a + (long)c * n;
    for (int l = first; l < c; l++) {
      const double* above = a + (long)l * n;
      const double f = -above[c] / above[l];
      add_scaled(row + c, f, above + c, n - c);
      x[c] += f * x[l];
    }
    if (!(row[c] > least_pivot)) return false;
  }
  return true;
}

// Three pivot rows from `first` on, and what they take off the rows below in the symmetric part: their
// entries over their pivots. Of fewer than three the rest are zero.
struct Pivots {
  const double* row[3];
  std::vector<double> share[3];

  void load(const double* a, int n, int first, int count) {
    for (int k = 0; k < 3; k++) {
      row[k] = a + (long)(first + std::min(k, count - 1)) * n;
      share[k].assign(n, 0.0);
      for (int c = first + count; c < n && k < count; c++)
        share[k][c] = row[k][c] / row[k][first + k];
    }
  }
};

// What they take off the rows of the other part, from s on, each by its own entries in their columns; x
// follows.
void take_off(double* a, int n, int s, int first, int count, Pivots& pivots, double* x) {
  const int rest = first + count;
  double* f[3];
  for (int k = 0; k < 3; k++) f[k] = pivots.share[k].data() + s;
  for (int r = s; r < n; r++) {
    const double* in = a + (long)r * n + first;
    for (int k = 0; k < count; k++) {
      double own = in[k];
      for (int l = 0; l < k; l++) own -= f[l][r - s] * pivots.row[l][first + k];
      f[k][r - s] = own / pivots.row[k][first + k];
      x[r] -= f[k][r - s] * x[first + k];
    }
  }
  subtract_three(a + (long)s * n + rest, n, n - s, n - rest, f[0], f[1], f[2], pivots.row[0] + rest,
                 pivots.row[1] + rest, pivots.row[2] + rest);
}

// The equations of the last rows, from s on, alone, as solve_dense() takes them.
bool solve_rest(const double* a, int n, int s, double least_pivot, double* x) {
  static thread_local std::vector<double> own, right;
  const int count = n - s, padded = (count + 2) / 3 * 3;
  own.assign((size_t)padded * padded, 0.0);
  right.assign(padded, 0.0);
  for (int r = 0; r < padded; r++) {
    double* row = &own[(size_t)r * padded];
    if (r < count)
      std::copy_n(a + (long)(s + r) * n + s, count, row), right[r] = x[s + r];
    else
      row[r] = 1;
  }
  if (!solve_dense(own.data(), padded, least_pivot, right.data())) return false;
  std::copy_n(right.begin(), count, x + s);
  return true;
}

}  // namespace

bool solve_mixed(double* a, int n, int s, double least_pivot, double* x) {
  static thread_local Pivots pivots;
  for (int first = 0; first < s; first += 3) {
    const int count = std::min(3, s - first), rest = first + count;
    if (!eliminate_symmetric(a, n, first, count, least_pivot, x)) return false;
    pivots.load(a, n, first, count);
    const auto share = [&](int k) { return pivots.share[k].data() + rest; };
    subtract_three_upper(a + (long)rest * n + rest, n, s - rest, n - rest, share(0), share(1),
                         share(2), pivots.row[0] + rest, pivots.row[1] + rest,
                         pivots.row[2] + rest);
    for (int k = 0; k < count; k++) add_scaled(x + rest, -x[first + k], share(k), s - rest);
    if (s < n) take_off(a, n, s, first, count, pivots, x);
  }
  if (!solve_rest(a, n, s, least_pivot, x)) return false;
  for (int r = s - 1; r >= 0; r--) {
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
      const double s = row[j] - inner(row, other, j);
      row[j] = i == j ? std::sqrt(std::max(s, least[i])) : s / other[j];
    }
  }
}

void solve_cholesky(const double* L, int n, double* x) {
  for (int i = 0; i < n; i++) {
    const double* row = L + (long)i * n;
    x[i] = (x[i] - inner(row, x, i)) / row[i];
  }
  for (int i = n - 1; i >= 0; i--) {
    const double* row = L + (long)i * n;
    x[i] /= row[i];
    add_scaled(x, -x[i], row, i);
  }
}

}  // namespace hp
