#include "math/elementary.h"

#include <cmath>
#include <limits>

namespace hp::elementary {

namespace {

constexpr double kInf = std::numeric_limits<double>::infinity();
constexpr double kNan = std::numeric_limits<double>::quiet_NaN();

// A number that is the sum of two, the first of which is it rounded.
struct Sum {
  double hi, lo;
};

// The nearest whole number, for |x| < 2^51.
double nearest(double x) {
  constexpr double kShift = 0x1.8p52;
  return (x + kShift) - kShift;
}

constexpr double kTwoOverPi = 0x1.45f306dc9c883p-1;
// pi/2 in parts of 33 bits: a multiple up to 2^20 of each of the first two is exact.
constexpr double kHalfPi1 = 0x1.921fb54400000p+0, kHalfPi2 = 0x1.0b4611a600000p-34,
                 kHalfPi3 = 0x1.3198a2e037073p-69;
constexpr Sum kPi{0x1.921fb54442d18p+1, 0x1.1a62633145c07p-53};
constexpr double kMostRadians = 1e5;

// x less the nearest multiple of pi/2; `quarter` is which of the four.
Sum reduced(double x, int& quarter) {
  if (std::fabs(x) > kMostRadians) x = std::fmod(x, 2 * kPi.hi);
  const double k = nearest(kTwoOverPi * x);
  const double rest = x - k * kHalfPi1, second = k * kHalfPi2;
  const double first = rest - second;
  // What the subtraction rounded off, and the third part.
  const double lost = (rest - first) - second - k * kHalfPi3;
  const double hi = first + lost;
  quarter = (int)((long long)k & 3);
  return {hi, (first - hi) + lost};
}

// Taylor's series, on |x| <= pi/4: what is left out is under 2^-60 of the result.
double sine(Sum x) {
  const double z = x.hi * x.hi;
  const double p =
      z *
      (1.0 / 120 +
       z * (-1.0 / 5040 +
            z * (1.0 / 362880 + z * (-1.0 / 39916800 +
                                     z * (1.0 / 6227020800 + z * (-1.0 / 1307674368000 +
                                                                  z * (1.0 / 355687428096000)))))));
  const double cube = z * x.hi;
  return x.hi + (cube * (p - 1.0 / 6) + x.lo * (1 - 0.5 * z));
}

double cosine(Sum x) {
  const double z = x.hi * x.hi, half = 0.5 * z, w = 1 - half;
  const double p =
      1.0 / 24 +
      z * (-1.0 / 720 +
           z * (1.0 / 40320 +
                z * (-1.0 / 3628800 +
                     z * (1.0 / 479001600 +
                          z * (-1.0 / 87178291200 +
                               z * (1.0 / 20922789888000 + z * (-1.0 / 6402373705728000)))))));
  return w + (((1 - w) - half) + (z * z * p - x.hi * x.lo));
}

// atan(k/16).
constexpr Sum kAtan[] = {
    {0x0.0p+0, 0x0.0p+0},
    {0x1.ff55bb72cfdeap-5, -0x1.c934d86d23f1dp-60},
    {0x1.fd5ba9aac2f6ep-4, -0x1.cd37686760c17p-59},
    {0x1.7b97b4bce5b02p-3, 0x1.347b0b4f881cap-58},
    {0x1.f5b75f92c80ddp-3, 0x1.8ab6e3cf7afbdp-57},
    {0x1.362773707ebccp-2, -0x1.963a544b672d8p-57},
    {0x1.6f61941e4def1p-2, -0x1.c63aae6f6e918p-56},
    {0x1.a64eec3cc23fdp-2, -0x1.24dec1b50b7ffp-56},
    {0x1.dac670561bb4fp-2, 0x1.a2b7f222f65e2p-56},
    {0x1.0657e94db30d0p-1, -0x1.d5b495f6349e6p-56},
    {0x1.1e00babdefeb4p-1, -0x1.928df287a668fp-58},
    {0x1.345f01cce37bbp-1, 0x1.1021137c71102p-55},
    {0x1.4978fa3269ee1p-1, 0x1.2419a87f2a458p-56},
    {0x1.5d58987169b18p-1, 0x1.0028e4bc5e7cap-57},
    {0x1.700a7c5784634p-1, -0x1.8c34d25aadef6p-56},
    {0x1.819d0b7158a4dp-1, -0x1.bf76229d3b917p-56},
    {0x1.921fb54442d18p-1, 0x1.1a62633145c07p-55},
};

// atan(y/x) for 0 <= y <= x, 0 < x: from the nearest k/16 by the formula for differences of angles.
Sum angle(double y, double x) {
  const double ratio = y / x, k = nearest(16 * ratio), c = k / 16;
  // u = (ratio - c) / (1 + ratio c); y - c x has c x rounded off, which fused() would not.
  double u = ratio;
  if (k > 0) {
    // c has at most five bits: x in two halves makes both products exact.
    constexpr double kSplit = 0x1p27 + 1;
    const double big = kSplit * x, high = big - (big - x), low = x - high;
    u = ((y - c * high) - c * low) / (x + c * y);
  }
  const double z = u * u;
  const double p =
      z * (-1.0 / 3 + z * (1.0 / 5 + z * (-1.0 / 7 + z * (1.0 / 9 + z * (-1.0 / 11)))));
  const Sum base = kAtan[(int)k];
  const double small = base.lo + u * p;
  const double hi = base.hi + u;
  return {hi, ((base.hi - hi) + u) + small};
}

// 2^(j/32).
constexpr Sum kPower[] = {
    {0x1.0000000000000p+0, 0x0.0p+0},
    {0x1.059b0d3158574p+0, 0x1.d73e2a475b465p-55},
    {0x1.0b5586cf9890fp+0, 0x1.8a62e4adc610bp-54},
    {0x1.11301d0125b51p+0, -0x1.6c51039449b3ap-54},
    {0x1.172b83c7d517bp+0, -0x1.19041b9d78a76p-55},
    {0x1.1d4873168b9aap+0, 0x1.e016e00a2643cp-54},
    {0x1.2387a6e756238p+0, 0x1.9b07eb6c70573p-54},
    {0x1.29e9df51fdee1p+0, 0x1.612e8afad1255p-55},
    {0x1.306fe0a31b715p+0, 0x1.6f46ad23182e4p-55},
    {0x1.371a7373aa9cbp+0, -0x1.63aeabf42eae2p-54},
    {0x1.3dea64c123422p+0, 0x1.ada0911f09ebcp-55},
    {0x1.44e086061892dp+0, 0x1.89b7a04ef80d0p-59},
    {0x1.4bfdad5362a27p+0, 0x1.d4397afec42e2p-56},
    {0x1.5342b569d4f82p+0, -0x1.07abe1db13cadp-55},
    {0x1.5ab07dd485429p+0, 0x1.6324c054647adp-54},
    {0x1.6247eb03a5585p+0, -0x1.383c17e40b497p-54},
    {0x1.6a09e667f3bcdp+0, -0x1.bdd3413b26456p-54},
    {0x1.71f75e8ec5f74p+0, -0x1.16e4786887a99p-55},
    {0x1.7a11473eb0187p+0, -0x1.41577ee04992fp-55},
    {0x1.82589994cce13p+0, -0x1.d4c1dd41532d8p-54},
    {0x1.8ace5422aa0dbp+0, 0x1.6e9f156864b27p-54},
    {0x1.93737b0cdc5e5p+0, -0x1.75fc781b57ebcp-57},
    {0x1.9c49182a3f090p+0, 0x1.c7c46b071f2bep-56},
    {0x1.a5503b23e255dp+0, -0x1.d2f6edb8d41e1p-54},
    {0x1.ae89f995ad3adp+0, 0x1.7a1cd345dcc81p-54},
    {0x1.b7f76f2fb5e47p+0, -0x1.5584f7e54ac3bp-56},
    {0x1.c199bdd85529cp+0, 0x1.11065895048ddp-55},
    {0x1.cb720dcef9069p+0, 0x1.503cbd1e949dbp-56},
    {0x1.d5818dcfba487p+0, 0x1.2ed02d75b3707p-55},
    {0x1.dfc97337b9b5fp+0, -0x1.1a5cd4f184b5cp-54},
    {0x1.ea4afa2a490dap+0, -0x1.e9c23179c2893p-54},
    {0x1.f50765b6e4540p+0, 0x1.9d3e12dd8a18bp-54},
};
constexpr double kSteps = 0x1.71547652b82fep+5;  // 32 / log 2
constexpr double kStep1 = 0x1.62e42fefa0000p-6, kStep2 = 0x1.cf79abc9e3b3ap-45;
constexpr Sum kLog2{0x1.62e42fefa3800p-1, 0x1.ef35793c76730p-45};

}  // namespace

void sin_cos(double x, double& s, double& c) {
  if (!(std::fabs(x) < kInf)) {
    s = c = kNan;
    return;
  }
  int quarter = 0;
  const Sum r = reduced(x, quarter);
  const double a = sine(r), b = cosine(r);
  s = quarter == 0 ? a : quarter == 1 ? b : quarter == 2 ? -a : -b;
  c = quarter == 0 ? b : quarter == 1 ? -a : quarter == 2 ? -b : a;
}

double sin(double x) {
  if (x == 0) return x;
  double s, c;
  sin_cos(x, s, c);
  return s;
}

double cos(double x) {
  double s, c;
  sin_cos(x, s, c);
  return c;
}

double tan(double x) {
  if (x == 0) return x;
  double s, c;
  sin_cos(x, s, c);
  return s / c;
}

double atan(double x) { return atan2(x, 1); }

double atan2(double y, double x) {
  if (std::isnan(x) || std::isnan(y)) return kNan;
  double a = std::fabs(x), b = std::fabs(y);
  if (a == kInf && b == kInf) a = b = 1;
  if (a == 0 && b == 0) return std::copysign(std::signbit(x) ? kPi.hi : 0.0, y);
  Sum t;
  if (b <= a) {
    t = a == kInf ? Sum{0, 0} : angle(b, a);
  } else {
    const Sum s = b == kInf ? Sum{0, 0} : angle(a, b);
    t = {0.5 * kPi.hi - s.hi, 0};
    t.lo = ((0.5 * kPi.hi - t.hi) - s.hi) + (0.5 * kPi.lo - s.lo);
  }
  if (std::signbit(x)) {
    const double hi = kPi.hi - t.hi;
    t = {hi, ((kPi.hi - hi) - t.hi) + (kPi.lo - t.lo)};
  }
  return std::copysign(t.hi + t.lo, y);
}

double asin(double x) {
  if (!(std::fabs(x) <= 1)) return kNan;
  return x == 0 ? x : atan2(x, std::sqrt((1 - x) * (1 + x)));
}

double acos(double x) {
  if (!(std::fabs(x) <= 1)) return kNan;
  return atan2(std::sqrt((1 - x) * (1 + x)), x);
}

double exp(double x) {
  if (std::isnan(x)) return x;
  if (x > 709.8) return kInf;
  if (x < -745.2) return 0;
  // x = k (log 2)/32 + r
  const double k = nearest(kSteps * x), hi = x - k * kStep1, lo = k * kStep2, r = hi - lo;
  const double lost = (hi - r) - lo;
  const double p = r * r * (0.5 + r * (1.0 / 6 + r * (1.0 / 24 + r * (1.0 / 120 + r / 720))));
  const int whole = (int)k, j = ((whole % 32) + 32) % 32;
  const Sum power = kPower[j];
  const double more = r + (p + lost);
  return std::ldexp(power.hi + (power.lo + power.hi * more), (whole - j) / 32);
}

double log(double x) {
  if (std::isnan(x) || x < 0) return kNan;
  if (x == 0) return -kInf;
  if (x == kInf) return x;
  int e = 0;
  double m = std::frexp(x, &e);  // in [0.5, 1)
  if (m < 0x1.6a09e667f3bcdp-1) m *= 2, e--;
  // log m = 2 atanh s, s = f / (2 + f)
  const double f = m - 1, s = f / (2 + f), z = s * s;
  const double p =
      z * (2.0 / 3 +
           z * (2.0 / 5 +
                z * (2.0 / 7 +
                     z * (2.0 / 9 +
                          z * (2.0 / 11 +
                               z * (2.0 / 13 +
                                    z * (2.0 / 15 +
                                         z * (2.0 / 17 + z * (2.0 / 19 + z * (2.0 / 21))))))))));
  // 2 s = f - s f; and f^2/2 apart, which keeps digits.
  const double half = 0.5 * f * f;
  return e * kLog2.hi - ((half - (s * (half + p) + e * kLog2.lo)) - f);
}

double pow(double base, double exponent) {
  if (exponent == 0 || base == 1) return 1;
  return exp(exponent * log(base));
}

double hypot(double x, double y) { return std::sqrt(x * x + y * y); }

}  // namespace hp::elementary
