// The few loops over long arrays. Where the compiler has vector types they take four doubles at
// once; the bits are the same with and without, on every machine: element by element the same
// operations in the same order, none of them fused.
#pragma once
#include <cstdlib>  // __GLIBC__

// Which instructions the core takes: 2, AVX2 where the processor has it, else those of every x86-64;
// 1, those of every x86-64 (SSE2) alone; 0, loops over single numbers. The bits are the same, which
// `tools/compare_results.py --vector` shows. Chosen by CMake's HALFPHYSICS_VECTORS.
#ifndef HP_VECTORS
#define HP_VECTORS 2
#endif

// On x86-64 Linux functions with this are compiled twice, and the machine chooses when the library is
// loaded. (Not under a sanitizer, whose own start comes too late for that.)
#if HP_VECTORS > 1 && defined(__x86_64__) && defined(__GLIBC__) && defined(__GNUC__) && \
    !defined(__SANITIZE_ADDRESS__)
#define HP_CLONES __attribute__((target_clones("avx2", "default")))
#else
#define HP_CLONES
#endif

namespace hp {

// Index of the largest dx x[i] + dy y[i] + dz z[i]: the first one of several.
int farthest(const double* x, const double* y, const double* z, int n, double dx, double dy,
             double dz);
// Index of the point nearest to (px, py, pz): the first one of several.
int nearest(const double* x, const double* y, const double* z, int n, double px, double py,
            double pz);
// out = p + R v for n points, coordinates one after the other in `v` and `out`; lo and hi receive
// the smallest and largest coordinates.
void transform(const double* v, int n, const double* R, const double* p, double* out, double* lo,
               double* hi);
// out += w (p + R v) for n points with weights w, or out = ... for the first of several;
// coordinates are `stride` apart in `v` and `out`.
void blend(const double* v, int stride, int n, const double* R, const double* p, const double* w,
           bool first, double* out);
// Smallest and largest of n numbers.
void limits(const double* v, int n, double& lo, double& hi);
// Sum of x[i] y[i]: in four sums, which are added up at the end.
double inner(const double* x, const double* y, int n);
// y += a x, over n numbers.
void add_scaled(double* y, double a, const double* x, int n);
// y += a x0 + b x1 + c x2, in this order for each number.
void add_scaled(double* y, double a, const double* x0, double b, const double* x1, double c,
                const double* x2, int n);

// Of rows of n numbers, `stride` apart:  a_r -= f[r] p + g[r] q + h[r] u, in this order.
void subtract_three(double* a, int stride, int rows, int n, const double* f, const double* g,
                    const double* h, const double* p, const double* q, const double* u);
// The same where only what is not below the diagonal counts.
void subtract_three_upper(double* a, int stride, int rows, int n, const double* f, const double* g,
                          const double* h, const double* p, const double* q, const double* u);

// For a < n and c <= a:  rows[start[at[a]] + c] -= sum over k of f[k] r_k[a] r_k[c]: three rows of a
// matrix leave those of their ancestors.
void eliminate(double* rows, const int* start, const int* at, int n, const double* r0,
               const double* r1, const double* r2, const double* f);

// Of a symmetric 6 x 6 matrix I in rows of 8: u = I s, d = s.u + e, gain = u / d, I -= gain u^T, and d.
// (dynamics/inertia_factor.h)
double give_way(double* I, const double* s, double e, double* gain);
// For the `count` dofs of a body, from the last one to the first: x = f + s^T p, p -= gain x^T and y =
// x, of three columns and a fourth; `p` has 6 rows of 4, `s` and `gain` 6 numbers per dof, `f` and `y`
// 4, y in the order of the work (dynamics/half_solve.h).
void pass_up(double* p, const double* s, const double* gain, int count, const double* f, double* y);

// s[4 p + q] = sum over k of x[4 at[k] + p] y[4 k + q], p and q < 3: how two sparse rows meet.
void meet(const double* x, const int* at, const double* y, int n, double* s);

}  // namespace hp
