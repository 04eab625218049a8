// Dense linear equations with some hundred unknowns at most, in place. Matrices are row-major.
#pragma once

namespace hp {

// Solves a x = b by Gaussian elimination with row exchanges. `a` (n, n) is overwritten; `x` is b on
// entry. n is a multiple of three: columns are eliminated three at a time, first among themselves,
// then from the rest, which touches each row of the rest once instead of three times. False, and `x`
// without meaning, if a pivot is not larger than `least_pivot`.
bool solve_dense(double* a, int n, double least_pivot, double* x);

// The same of a matrix whose first s rows and columns are symmetric and positive definite: of those the
// upper triangle alone is read, and half the work is done; n and s are any. The other rows follow as the
// Schur complement, with row exchanges among them.
bool solve_mixed(double* a, int n, int s, double least_pivot, double* x);

// a = L L^T for a symmetric matrix (n, n), of which the lower triangle is read and overwritten by L.
// Squares of pivots are raised to `least` (n) where they are smaller.
void factor_cholesky(double* a, int n, const double* least);

// x <- (L L^T)^-1 x.
void solve_cholesky(const double* L, int n, double* x);

}  // namespace hp
