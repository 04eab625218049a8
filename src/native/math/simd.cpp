#include "math/simd.h"

#include <algorithm>
#include <cstdlib>

namespace hp {

#if HP_VECTORS > 0 && defined(__GNUC__)

namespace {

typedef double V __attribute__((vector_size(32), aligned(8), may_alias));
typedef long long I __attribute__((vector_size(32)));

}  // namespace

HP_CLONES int farthest(const double* x, const double* y, const double* z, int n, double dx,
                       double dy, double dz) {
  double best = -1e300;
  int at = 0, i = 0;
  if (n >= 16) {
    // Two at a time, so that comparisons do not wait for each other.
    V most = {-1e300, -1e300, -1e300, -1e300}, most2 = most;
    I where = {0, 0, 0, 0}, where2 = where, here = {0, 1, 2, 3};
    for (; i + 8 <= n; i += 8) {
      V s = dx * *(const V*)(x + i) + dy * *(const V*)(y + i) + dz * *(const V*)(z + i);
      V s2 =
          dx * *(const V*)(x + i + 4) + dy * *(const V*)(y + i + 4) + dz * *(const V*)(z + i + 4);
      I more = s > most, more2 = s2 > most2;
      most = more ? s : most, most2 = more2 ? s2 : most2;
      where = more ? here : where, where2 = more2 ? here + 4 : where2;
      here += 8;
    }
    auto take = [&](double s, long long k) {
      if (s > best || (s == best && k < at)) best = s, at = (int)k;
    };
    for (int k = 0; k < 4; k++) take(most[k], where[k]), take(most2[k], where2[k]);
  }
  for (; i < n; i++) {
    double s = dx * x[i] + dy * y[i] + dz * z[i];
    if (s > best) best = s, at = i;
  }
  return at;
}

HP_CLONES int nearest(const double* x, const double* y, const double* z, int n, double px,
                      double py, double pz) {
  double best = 1e300;
  int at = 0, i = 0;
  if (n >= 8) {
    V least = {1e300, 1e300, 1e300, 1e300};
    I where = {0, 0, 0, 0}, here = {0, 1, 2, 3};
    for (; i + 4 <= n; i += 4) {
      const V u = *(const V*)(x + i) - px, v = *(const V*)(y + i) - py, w = *(const V*)(z + i) - pz;
      const V s = u * u + v * v + w * w;
      const I less = s < least;
      least = less ? s : least;
      where = less ? here : where;
      here += 4;
    }
    for (int k = 0; k < 4; k++)
      if (least[k] < best || (least[k] == best && where[k] < at))
        best = least[k], at = (int)where[k];
  }
  for (; i < n; i++) {
    const double u = x[i] - px, v = y[i] - py, w = z[i] - pz, s = u * u + v * v + w * w;
    if (s < best) best = s, at = i;
  }
  return at;
}

HP_CLONES void transform(const double* v, int n, const double* R, const double* p, double* out,
                         double* lo, double* hi) {
  const double *x = v, *y = v + n, *z = v + 2 * n;
  for (int k = 0; k < 3; k++) {
    const double a = R[3 * k], b = R[3 * k + 1], c = R[3 * k + 2], q = p[k];
    double* o = out + (size_t)k * n;
    double least = 1e300, most = -1e300;
    int i = 0;
    if (n >= 8) {
      V low = {1e300, 1e300, 1e300, 1e300}, high = -low;
      for (; i + 4 <= n; i += 4) {
        V s = q + (a * *(const V*)(x + i) + b * *(const V*)(y + i) + c * *(const V*)(z + i));
        *(V*)(o + i) = s;
        low = s < low ? s : low;
        high = s > high ? s : high;
      }
      for (int l = 0; l < 4; l++) least = std::min(least, low[l]), most = std::max(most, high[l]);
    }
    for (; i < n; i++) {
      double s = q + (a * x[i] + b * y[i] + c * z[i]);
      o[i] = s;
      least = std::min(least, s), most = std::max(most, s);
    }
    lo[k] = least, hi[k] = most;
  }
}

HP_CLONES void blend(const double* v, int stride, int n, const double* R, const double* p,
                     const double* w, bool first, double* out) {
  const double *x = v, *y = v + stride, *z = v + 2 * (size_t)stride;
  for (int k = 0; k < 3; k++) {
    const double a = R[3 * k], b = R[3 * k + 1], c = R[3 * k + 2], q = p[k];
    double* o = out + (size_t)k * stride;
    int i = 0;
    for (; first && i + 4 <= n; i += 4)
      *(V*)(o + i) =
          *(const V*)(w + i) *
          (q + (a * *(const V*)(x + i) + b * *(const V*)(y + i) + c * *(const V*)(z + i)));
    for (; i + 4 <= n; i += 4)
      *(V*)(o + i) +=
          *(const V*)(w + i) *
          (q + (a * *(const V*)(x + i) + b * *(const V*)(y + i) + c * *(const V*)(z + i)));
    for (; i < n; i++) {
      const double s = w[i] * (q + (a * x[i] + b * y[i] + c * z[i]));
      o[i] = first ? s : o[i] + s;
    }
  }
}

HP_CLONES void limits(const double* v, int n, double& lo, double& hi) {
  lo = 1e300, hi = -1e300;
  int i = 0;
  if (n >= 8) {
    V low = {1e300, 1e300, 1e300, 1e300}, high = -low;
    for (; i + 4 <= n; i += 4) {
      const V s = *(const V*)(v + i);
      low = s < low ? s : low;
      high = s > high ? s : high;
    }
    for (int l = 0; l < 4; l++) lo = std::min(lo, low[l]), hi = std::max(hi, high[l]);
  }
  for (; i < n; i++) lo = std::min(lo, v[i]), hi = std::max(hi, v[i]);
}

HP_CLONES double inner(const double* x, const double* y, int n) {
  V sum = {0, 0, 0, 0};
  int i = 0;
  for (; i + 4 <= n; i += 4) sum += *(const V*)(x + i) * *(const V*)(y + i);
  double s = (sum[0] + sum[1]) + (sum[2] + sum[3]);
  for (; i < n; i++) s += x[i] * y[i];
  return s;
}

HP_CLONES void add_scaled(double* y, double a, const double* x, int n) {
  int i = 0;
  for (; i + 4 <= n; i += 4) *(V*)(y + i) += a * *(const V*)(x + i);
  for (; i < n; i++) y[i] += a * x[i];
}

HP_CLONES void add_scaled(double* y, double a, const double* x0, double b, const double* x1,
                          double c, const double* x2, int n) {
  int i = 0;
  for (; i + 4 <= n; i += 4)
    *(V*)(y + i) += a * *(const V*)(x0 + i) + b * *(const V*)(x1 + i) + c * *(const V*)(x2 + i);
  for (; i < n; i++) y[i] += a * x0[i] + b * x1[i] + c * x2[i];
}

HP_CLONES void subtract_three(double* a, int stride, int rows, int n, const double* f,
                              const double* g, const double* h, const double* p, const double* q,
                              const double* u) {
  for (int r = 0; r < rows; r++, a += stride) {
    const double x = f[r], y = g[r], z = h[r];
    int i = 0;
    for (; i + 4 <= n; i += 4)
      *(V*)(a + i) -= x * *(const V*)(p + i) + y * *(const V*)(q + i) + z * *(const V*)(u + i);
    for (; i < n; i++) a[i] -= x * p[i] + y * q[i] + z * u[i];
  }
}

HP_CLONES void subtract_three_upper(double* a, int stride, int rows, int n, const double* f,
                                    const double* g, const double* h, const double* p,
                                    const double* q, const double* u) {
  for (int r = 0; r < rows; r++, a += stride) {
    const double x = f[r], y = g[r], z = h[r];
    int i = r & ~3;
    for (; i + 4 <= n; i += 4)
      *(V*)(a + i) -= x * *(const V*)(p + i) + y * *(const V*)(q + i) + z * *(const V*)(u + i);
    for (; i < n; i++) a[i] -= x * p[i] + y * q[i] + z * u[i];
  }
}

HP_CLONES void eliminate(double* rows, const int* start, const int* at, int n, const double* r0,
                         const double* r1, const double* r2, const double* f) {
  for (int a = 0; a < n; a++) {
    double* y = rows + start[at[a]];
    const double p = -f[0] * r0[a], q = -f[1] * r1[a], r = -f[2] * r2[a];
    int c = 0;
    for (; c + 4 <= a + 1; c += 4)
      *(V*)(y + c) = *(const V*)(y + c) + p * *(const V*)(r0 + c) + q * *(const V*)(r1 + c) +
                     r * *(const V*)(r2 + c);
    for (; c <= a; c++) y[c] = y[c] + p * r0[c] + q * r1[c] + r * r2[c];
  }
}

HP_CLONES double give_way(double* I, const double* s, double e, double* gain) {
  V lo = {0, 0, 0, 0}, hi = lo;
  for (int k = 0; k < 6; k++) {
    lo += s[k] * *(const V*)(I + 8 * k);
    hi += s[k] * *(const V*)(I + 8 * k + 4);
  }
  double u[8];
  *(V*)u = lo, *(V*)(u + 4) = hi;
  double d = e;
  for (int k = 0; k < 6; k++) d += s[k] * u[k];
  const double f = 1 / d;
  for (int k = 0; k < 6; k++) {
    const double g = gain[k] = f * u[k];
    *(V*)(I + 8 * k) -= g * lo;
    *(V*)(I + 8 * k + 4) -= g * hi;
  }
  return d;
}

HP_CLONES void pass_up(double* p, const double* s, const double* gain, int count, const double* f,
                       double* y) {
  V w[6];
  for (int k = 0; k < 6; k++) w[k] = *(const V*)(p + 4 * k);
  for (int i = count - 1; i >= 0; i--, y += 4) {
    V x = *(const V*)(f + 4 * i);
    for (int k = 0; k < 6; k++) x += s[6 * i + k] * w[k];
    for (int k = 0; k < 6; k++) w[k] -= gain[6 * i + k] * x;
    *(V*)y = x;
  }
  for (int k = 0; k < 6; k++) *(V*)(p + 4 * k) = w[k];
}

HP_CLONES void meet(const double* x, const int* at, const double* y, int n, double* s) {
  V s0 = {0, 0, 0, 0}, s1 = s0, s2 = s0;
  for (int k = 0; k < n; k++) {
    const double* a = x + 4 * at[k];
    const V b = *(const V*)(y + 4 * (size_t)k);
    s0 += a[0] * b, s1 += a[1] * b, s2 += a[2] * b;
  }
  *(V*)s = s0, *(V*)(s + 4) = s1, *(V*)(s + 8) = s2;
}

#else

int nearest(const double* x, const double* y, const double* z, int n, double px, double py,
            double pz) {
  double best = 1e300;
  int at = 0;
  for (int i = 0; i < n; i++) {
    const double u = x[i] - px, v = y[i] - py, w = z[i] - pz, s = u * u + v * v + w * w;
    if (s < best) best = s, at = i;
  }
  return at;
}

void eliminate(double* rows, const int* start, const int* at, int n, const double* r0,
               const double* r1, const double* r2, const double* f) {
  for (int a = 0; a < n; a++) {
    double* y = rows + start[at[a]];
    const double p = -f[0] * r0[a], q = -f[1] * r1[a], r = -f[2] * r2[a];
    for (int c = 0; c <= a; c++) y[c] = y[c] + p * r0[c] + q * r1[c] + r * r2[c];
  }
}

void blend(const double* v, int stride, int n, const double* R, const double* p, const double* w,
           bool first, double* out) {
  const double *x = v, *y = v + stride, *z = v + 2 * (size_t)stride;
  for (int k = 0; k < 3; k++)
    for (int i = 0; i < n; i++) {
      double& o = out[(size_t)k * stride + i];
      const double s =
          w[i] * (p[k] + (R[3 * k] * x[i] + R[3 * k + 1] * y[i] + R[3 * k + 2] * z[i]));
      o = first ? s : o + s;
    }
}

void limits(const double* v, int n, double& lo, double& hi) {
  lo = 1e300, hi = -1e300;
  for (int i = 0; i < n; i++) lo = std::min(lo, v[i]), hi = std::max(hi, v[i]);
}

double inner(const double* x, const double* y, int n) {
  double sum[4] = {0, 0, 0, 0};
  int i = 0;
  for (; i + 4 <= n; i += 4)
    for (int k = 0; k < 4; k++) sum[k] += x[i + k] * y[i + k];
  double s = (sum[0] + sum[1]) + (sum[2] + sum[3]);
  for (; i < n; i++) s += x[i] * y[i];
  return s;
}

double give_way(double* I, const double* s, double e, double* gain) {
  double u[6] = {0, 0, 0, 0, 0, 0};
  for (int k = 0; k < 6; k++)
    for (int c = 0; c < 6; c++) u[c] += s[k] * I[8 * k + c];
  double d = e;
  for (int k = 0; k < 6; k++) d += s[k] * u[k];
  const double f = 1 / d;
  for (int k = 0; k < 6; k++) {
    gain[k] = f * u[k];
    for (int c = 0; c < 6; c++) I[8 * k + c] -= gain[k] * u[c];
  }
  return d;
}

void pass_up(double* p, const double* s, const double* gain, int count, const double* f,
             double* y) {
  for (int i = count - 1; i >= 0; i--, y += 4)
    for (int q = 0; q < 4; q++) {
      double x = f[4 * i + q];
      for (int k = 0; k < 6; k++) x += s[6 * i + k] * p[4 * k + q];
      for (int k = 0; k < 6; k++) p[4 * k + q] -= gain[6 * i + k] * x;
      y[q] = x;
    }
}

void subtract_three(double* a, int stride, int rows, int n, const double* f, const double* g,
                    const double* h, const double* p, const double* q, const double* u) {
  for (int r = 0; r < rows; r++, a += stride)
    for (int i = 0; i < n; i++) a[i] -= f[r] * p[i] + g[r] * q[i] + h[r] * u[i];
}

void subtract_three_upper(double* a, int stride, int rows, int n, const double* f, const double* g,
                          const double* h, const double* p, const double* q, const double* u) {
  for (int r = 0; r < rows; r++, a += stride)
    for (int i = r & ~3; i < n; i++) a[i] -= f[r] * p[i] + g[r] * q[i] + h[r] * u[i];
}

void meet(const double* x, const int* at, const double* y, int n, double* s) {
  for (int i = 0; i < 12; i++) s[i] = 0;
  for (int k = 0; k < n; k++)
    for (int p = 0; p < 3; p++)
      for (int q = 0; q < 4; q++) s[4 * p + q] += x[4 * at[k] + p] * y[4 * k + q];
}

int farthest(const double* x, const double* y, const double* z, int n, double dx, double dy,
             double dz) {
  double best = -1e300;
  int at = 0;
  for (int i = 0; i < n; i++) {
    double s = dx * x[i] + dy * y[i] + dz * z[i];
    if (s > best) best = s, at = i;
  }
  return at;
}

void transform(const double* v, int n, const double* R, const double* p, double* out, double* lo,
               double* hi) {
  for (int k = 0; k < 3; k++) {
    lo[k] = 1e300, hi[k] = -1e300;
    for (int i = 0; i < n; i++) {
      double s = p[k] + (R[3 * k] * v[i] + R[3 * k + 1] * v[n + i] + R[3 * k + 2] * v[2 * n + i]);
      out[k * n + i] = s;
      lo[k] = std::min(lo[k], s), hi[k] = std::max(hi[k], s);
    }
  }
}

void add_scaled(double* y, double a, const double* x, int n) {
  for (int i = 0; i < n; i++) y[i] += a * x[i];
}

void add_scaled(double* y, double a, const double* x0, double b, const double* x1, double c,
                const double* x2, int n) {
  for (int i = 0; i < n; i++) y[i] += a * x0[i] + b * x1[i] + c * x2[i];
}

#endif

}  // namespace hp
