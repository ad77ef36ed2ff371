#include "angle.hpp"

namespace rvdnav {
namespace {

constexpr ArcTangent make_arc_tangent() {
  ArcTangent table = {};
  for (int32_t i = 0; i <= kRatioSteps; ++i) {
    const double x = static_cast<double>(i) / kRatioSteps;
    // Euler's series of the arc tangent; its terms at least halve where |x| <= 1.
    const double shrink = x * x / (1.0 + x * x);
    double term = x / (1.0 + x * x), sum = term;
    for (int n = 1; n < 60; ++n) {
      term *= shrink * (2.0 * n) / (2.0 * n + 1.0);
      sum += term;
    }
    table.level[i] = round_half_away(sum * (128.0 / 3.14159265358979323846));
  }
  return table;
}

}  // namespace

const ArcTangent kArcTangent = make_arc_tangent();

uint8_t binary_angle(int32_t x, int32_t y) {
  const int32_t ax = x < 0 ? -x : x;
  const int32_t ay = y < 0 ? -y : y;
  if (ax == 0 && ay == 0) return 0;
  int32_t level = 0;  // in the first quarter
  if (ax >= ay) {
    level = kArcTangent.level[(ay * kRatioSteps + ax / 2) / ax];
  } else {
    level = 64 - kArcTangent.level[(ax * kRatioSteps + ay / 2) / ay];
  }
  if (x < 0) level = 128 - level;
  if (y < 0) level = 256 - level;
  return static_cast<uint8_t>(level & 255);
}

}  // namespace rvdnav
