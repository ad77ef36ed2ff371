#include "math/elementary.hpp"

#include <cmath>
#include <cstdint>
#include <cstring>
#include <limits>

namespace rvdnav {
namespace math {
namespace {

constexpr double kNaN = std::numeric_limits<double>::quiet_NaN();
constexpr double kInfinity = std::numeric_limits<double>::infinity();
constexpr double kHalfPi = 1.5707963267948966, kHalfPiLow = 6.123233995736766e-17;

// c[0] + c[1] x + c[2] x^2 + ...
template <int kTerms>
double polynomial(const double (&c)[kTerms], double x) {
  double sum = c[kTerms - 1];
  for (int i = kTerms - 2; i >= 0; --i) sum = sum * x + c[i];
  return sum;
}

uint64_t bits_of(double x) {
  uint64_t bits = 0;
  std::memcpy(&bits, &x, sizeof bits);
  return bits;
}

double double_of(uint64_t bits) {
  double x = 0.0;
  std::memcpy(&x, &bits, sizeof x);
  return x;
}

double power_of_two(int32_t n) { return double_of(static_cast<uint64_t>(n + 1023) << 52); }  // n: -1022..1023

int32_t nearest(double x) { return static_cast<int32_t>(x < 0.0 ? x - 0.5 : x + 0.5); }

// An angle less quarter * pi/2: value + low, within pi/4 and a little.
struct Reduced {
  double value, low;
  int32_t quarter;
};

constexpr double kLargestAngle = 1048576.0;

Reduced reduce(double x) {
  // pi/2 in three parts; the first two have 33 bits, so that their products with the quarters are exact.
  constexpr double kPart1 = 1.5707963267341256, kPart2 = 6.077100506303966e-11, kPart3 = 2.0222662487959506e-21;
  constexpr double kQuarters = 0.6366197723675814;  // 2 / pi
  const int32_t quarter = nearest(x * kQuarters);
  const double n = quarter;
  const double first = x - n * kPart1;  // exact
  const double second = n * kPart2;
  const double sum = first - second;
  const double taken = first - sum;
  const double lost = (first - (sum + taken)) + (taken - second);  // first - second = sum + lost exactly
  const double tail = lost - n * kPart3;
  const double value = sum + tail;
  return {value, (sum - value) + tail, quarter};
}

// Taylor's series within pi/4; the low part enters by its derivative.
double sin_near_zero(double x, double low) {
  // -1/3!, 1/5!, ...
  constexpr double kSeries[] = {
      -0.16666666666666666,   0.008333333333333333,   -0.0001984126984126984,
      2.7557319223985893e-06, -2.505210838544172e-08, 1.6059043836821613e-10,
      -7.647163731819816e-13, 2.8114572543455206e-15, -8.22063524662433e-18,
  };
  const double z = x * x;
  return x + (x * z * polynomial(kSeries, z) + low * (1.0 - 0.5 * z));
}

double cos_near_zero(double x, double low) {
  // 1/4!, -1/6!, ...
  constexpr double kSeries[] = {
      0.041666666666666664, -0.001388888888888889,   2.48015873015873e-05,  -2.755731922398589e-07,
      2.08767569878681e-09, -1.1470745597729725e-11, 4.779477332387385e-14, -1.5619206968586225e-16,
  };
  const double z = x * x;
  const double half = 0.5 * z;
  const double head = 1.0 - half;
  return head + (((1.0 - head) - half) + (z * z * polynomial(kSeries, z) - x * low));
}

// The sine of quarter more quarter turns.
double sin_of_quarters(const Reduced& r, int32_t quarter) {
  const double value = (quarter & 1) == 0 ? sin_near_zero(r.value, r.low) : cos_near_zero(r.value, r.low);
  return (quarter & 2) == 0 ? value : -value;
}

// exp(x) - 1 for |x| below 0.0015.
double expm1_near_zero(double x) { return x * (1.0 + x * (0.5 + x * (1.0 / 6.0 + x * (1.0 / 24.0)))); }

// exp(x^2) erfc(x) (1 + 2 x) for x from 0.5 to 27.5 as a polynomial of (x - 4) / (x + 4): a Chebyshev fit of our own
// with a largest error of 8e-19.
double scaled_erfc(double x) {
  constexpr double kFit[] = {
      1.2329951186255526,     -0.1396211168405625,     0.015379652102619889,    0.06809705425468865,
      -0.1010390660363134,    0.09373283499852571,     -0.06633036581199489,    0.03716751553395706,
      -0.01619773406064773,   0.005031970016893833,    -0.0007577732671571896,  -0.0001992569552452226,
      0.00015062157616003925, -2.4398096966776398e-05, -1.1221740812863639e-05, 5.70659079496564e-06,
      2.932953220786808e-07,  -8.196509393382735e-07,  7.517429508468966e-08,   1.0337458066730016e-07,
      -1.822353778780082e-08, -9.693963684144484e-09,  1.909020070722797e-09,
  };
  return polynomial(kFit, (x - 4.0) / (x + 4.0)) / (1.0 + 2.0 * x);
}

double erfc_of_positive(double x) {
  if (x > 27.5) return 0.0;
  // The square in an exact part, from the upper half of x's bits, and the small rest.
  const double upper = double_of(bits_of(x) & 0xffffffff00000000U);
  const double rest = (x - upper) * (x + upper);
  const double main = math::exp(-upper * upper) * scaled_erfc(x);
  return main + main * expm1_near_zero(-rest);
}

}  // namespace

double sin(double x) {
  if (!(std::abs(x) <= kLargestAngle)) return kNaN;
  if (std::abs(x) < 1e-8) return x;  // a zero keeps its sign
  const Reduced r = reduce(x);
  return sin_of_quarters(r, r.quarter);
}

double cos(double x) {
  if (!(std::abs(x) <= kLargestAngle)) return kNaN;
  const Reduced r = reduce(x);
  return sin_of_quarters(r, r.quarter + 1);
}

double atan(double x) {
  // atan(i/8) and what it lacks.
  constexpr double kEighths[9] = {0.0,
                                  0.12435499454676144,
                                  0.24497866312686414,
                                  0.35877067027057225,
                                  0.4636476090008061,
                                  0.5585993153435624,
                                  0.6435011087932844,
                                  0.7188299996216245,
                                  0.7853981633974483};
  constexpr double kEighthsLow[9] = {0.0,
                                     -3.1253241424539383e-18,
                                     1.0698755618734451e-17,
                                     -2.4623815582638635e-17,
                                     2.2698777452961687e-17,
                                     -5.4556305485916264e-18,
                                     1.5834785051444286e-17,
                                     -2.1478388444456983e-17,
                                     3.061616997868383e-17};
  // -1/3, 1/5, ...
  constexpr double kSeries[] = {
      -0.3333333333333333,  0.2, -0.14285714285714285, 0.1111111111111111, -0.09090909090909091, 0.07692307692307693,
      -0.06666666666666667,
  };
  if (x != x) return x;
  const double size = std::abs(x);
  const bool steep = size > 1.0;
  const double slope = steep ? 1.0 / size : size;
  // atan(slope) = atan(c) + atan((slope - c) / (1 + slope c)), c the nearest eighth.
  const int32_t i = nearest(8.0 * slope);
  const double c = i * 0.125;
  const double t = (slope - c) / (1.0 + slope * c);
  const double z = t * t;
  const double part = t * z * polynomial(kSeries, z) + kEighthsLow[i];
  double angle = kEighths[i] + (t + part);
  if (steep) angle = kHalfPi - (angle - kHalfPiLow);
  return std::copysign(angle, x);
}

double atan2(double y, double x) {
  const double across = std::abs(y), along = std::abs(x);
  if (x != x || y != y) return kNaN;
  double angle = 0.0;
  if (across > along) {
    const double beyond = std::copysign(math::atan(along / across), x);
    angle = kHalfPi - (beyond - kHalfPiLow);
  } else {
    angle = along > 0.0 ? math::atan(across / along) : 0.0;
    if (std::signbit(x)) angle = 2.0 * kHalfPi - (angle - 2.0 * kHalfPiLow);
  }
  return std::copysign(angle, y);
}

double exp(double x) {
  // 1/2!, 1/3!, ...
  constexpr double kSeries[] = {
      0.5,
      0.16666666666666666,
      0.041666666666666664,
      0.008333333333333333,
      0.001388888888888889,
      0.0001984126984126984,
      2.48015873015873e-05,
      2.7557319223985893e-06,
      2.755731922398589e-07,
      2.505210838544172e-08,
      2.08767569878681e-09,
      1.6059043836821613e-10,
      1.1470745597729725e-11,
  };
  constexpr double kLog2 = 0.6931471805592082, kLog2Low = 7.371002565167799e-13;  // the first with 40 bits
  constexpr double kInverseLog2 = 1.4426950408889634;
  if (x != x) return x;
  if (x > 709.8) return kInfinity;
  if (x < -745.2) return 0.0;
  const int32_t n = nearest(x * kInverseLog2);
  const double head = x - n * kLog2;  // exact
  const double low = n * kLog2Low;
  const double r = head - low;
  const double value = 1.0 + (head + (r * r * polynomial(kSeries, r) - low));
  // In two steps, as 2^n may be no normal number.
  return value * power_of_two(n / 2) * power_of_two(n - n / 2);
}

double log(double x) {
  // 2/3, 2/5, ...: log((1 + s) / (1 - s)) = 2 s + 2/3 s^3 + ...
  constexpr double kSeries[] = {
      0.6666666666666666,  0.4,
      0.2857142857142857,  0.2222222222222222,
      0.18181818181818182, 0.15384615384615385,
      0.13333333333333333, 0.11764705882352941,
      0.10526315789473684, 0.09523809523809523,
      0.08695652173913043,
  };
  constexpr double kLog2 = 0.6931471805592082, kLog2Low = 7.371002565167799e-13;
  constexpr double kSqrt2 = 1.4142135623730951;
  if (x != x || x < 0.0) return kNaN;
  if (x == 0.0) return -kInfinity;
  if (x == kInfinity) return x;
  int32_t n = 0;
  if (x < std::numeric_limits<double>::min()) {
    x *= 18014398509481984.0;  // 2^54
    n = -54;
  }
  const uint64_t bits = bits_of(x);
  n += static_cast<int32_t>(bits >> 52) - 1023;
  double m = double_of((bits & 0xfffffffffffffU) | 0x3ff0000000000000U);
  if (m > kSqrt2) {
    m *= 0.5;
    ++n;
  }
  // log(1 + f) = f - f^2/2 + s (f^2/2 + 2/3 s^2 + ...), whose large terms are exact or small.
  const double f = m - 1.0;
  const double s = f / (2.0 + f);
  const double z = s * s;
  const double half_square = 0.5 * f * f;
  const double rest = s * (half_square + z * polynomial(kSeries, z));
  return n * kLog2 - ((half_square - (rest + n * kLog2Low)) - f);
}

double erfc(double x) {
  // 2/sqrt(pi) (1, -1/3, 1/(5 2!), ...)
  constexpr double kSeries[] = {
      1.1283791670955126,     -0.37612638903183754,    0.11283791670955126,    -0.026866170645131252,
      0.005223977625442188,   -0.0008548327023450853,  0.00012055332981789664, -1.492565035840625e-05,
      1.6462114365889248e-06, -1.6365844691234924e-07, 1.4807192815879218e-08, -1.2290555301717928e-09,
      9.422759064650411e-11,  -6.7113668551641105e-12,
  };
  if (x != x) return x;
  if (std::abs(x) < 0.5) return 1.0 - x * polynomial(kSeries, x * x);
  return x > 0.0 ? erfc_of_positive(x) : 2.0 - erfc_of_positive(-x);
}

}  // namespace math
}  // namespace rvdnav
