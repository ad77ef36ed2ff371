// Sub-bin positions of maxima, in integers.
#pragma once

#include "integers.hpp"
#include "hough.hpp"

namespace rvdnav {

// Where the parabola through three neighbouring values has its top, from the middle one, in 1/256 of a step; at most
// half a step away, and 0 without a top.
constexpr int32_t parabola_q8(int32_t before, int32_t middle, int32_t after) {
  const int32_t curvature = 2 * middle - before - after;
  if (curvature <= 0) return 0;
  const int32_t top = round_divide(128 * (after - before), curvature);
  return top < -128 ? -128 : top > 128 ? 128 : top;
}

// The same line with theta in [-45, 135) degrees; from at most half a turn away.
constexpr rvdnav_peak half_turn_normalised(rvdnav_peak peak) {
  constexpr int32_t kFirst = kThetaFirst * 256, kHalfTurn = 180 * 256;
  if (peak.theta_q8 < kFirst) return {-peak.rho_q8, peak.theta_q8 + kHalfTurn, peak.votes};
  if (peak.theta_q8 >= kFirst + kHalfTurn) return {-peak.rho_q8, peak.theta_q8 - kHalfTurn, peak.votes};
  return peak;
}

}  // namespace rvdnav
