// Angles in integers: tables that the compiler computes from + - * / alone, so that every build has the same.
#pragma once

#include <stdint.h>

#include "integers.hpp"

namespace rvdnav {

struct CosSin {
  double c, s;
};

// Cosine and sine of an angle in degrees, to the last bits: reduced to +-45 degrees, then their power series.
constexpr CosSin cos_sin_degrees(double degrees) {
  int quarters = 0;
  while (degrees > 45.0) {
    degrees -= 90.0;
    ++quarters;
  }
  while (degrees < -45.0) {
    degrees += 90.0;
    quarters += 3;
  }
  const double x = degrees * (3.14159265358979323846 / 180.0);
  double c = 1.0, s = x, c_term = 1.0, s_term = x;
  for (int k = 1; k < 12; ++k) {
    c_term *= -x * x / ((2 * k - 1) * (2 * k));
    s_term *= -x * x / ((2 * k) * (2 * k + 1));
    c += c_term;
    s += s_term;
  }
  switch (quarters % 4) {
    case 0:
      return {c, s};
    case 1:
      return {-s, c};
    case 2:
      return {-c, -s};
    default:
      return {s, -c};
  }
}

struct UnitQ14 {
  int16_t c, s;
};

constexpr UnitQ14 unit_q14(double degrees) {
  const CosSin exact = cos_sin_degrees(degrees);
  return {static_cast<int16_t>(round_half_away(exact.c * 16384.0)),
          static_cast<int16_t>(round_half_away(exact.s * 16384.0))};
}

constexpr int32_t kRatioSteps = 128;

struct ArcTangent {
  int32_t level[kRatioSteps + 1];  // of the ratios 0..1, 256 to the turn: 0..32
};

extern const ArcTangent kArcTangent;

// Binary angle of a vector: 256 levels to the turn, from +x towards +y; 0 for the null vector.  Wrong by at most one
// level (0.7 of one).  Components up to 2^24 in size.
uint8_t binary_angle(int32_t x, int32_t y);

}  // namespace rvdnav
