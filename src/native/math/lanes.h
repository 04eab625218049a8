// Numbers of several things at once, for loops over columns of numbers: four where the compiler has vector types,
// else one. The bits are the same. A loop's function is marked HP_CLONES (simd.h), what it calls HP_INLINE.
#pragma once
#include <cmath>

#include "math/simd.h"

namespace hp {

#if HP_VECTORS > 0 && defined(__GNUC__)
#ifndef __clang__
#pragma GCC diagnostic ignored "-Wpsabi"  // how lanes are passed: they never are, all is inlined
#endif
typedef double Lanes __attribute__((vector_size(32), aligned(8), may_alias));
constexpr int kLanes = 4;
#define HP_INLINE inline __attribute__((always_inline))

HP_INLINE Lanes square_root(const Lanes& x) {
  Lanes r;
  for (int k = 0; k < kLanes; k++) r[k] = std::sqrt(x[k]);
  return r;
}
HP_INLINE double least_of(const Lanes& x) {
  double least = x[0];
  for (int k = 1; k < kLanes; k++) least = x[k] < least ? x[k] : least;
  return least;
}
#else
using Lanes = double;
constexpr int kLanes = 1;
#define HP_INLINE inline

inline Lanes square_root(Lanes x) { return std::sqrt(x); }
inline double least_of(Lanes x) { return x; }
#endif

HP_INLINE Lanes& lanes(double* at) { return *(Lanes*)at; }
HP_INLINE const Lanes& lanes(const double* at) { return *(const Lanes*)at; }

}  // namespace hp
