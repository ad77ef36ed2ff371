// Stage 4: the Hough accumulator over (rho, theta).
//
// Row b stands for theta = b - 45 degrees, cell r of it for rho = r - rho_bins / 2 pixels, rounded to the nearest.  An
// edge pixel votes only near its gradient's direction, modulo half a turn: edges of both polarities share a row.
#pragma once

#include "kernels/kernels.hpp"
#include "rvdnav/rvdnav.h"
#include "types.hpp"

namespace rvdnav {

constexpr int32_t kThetaBins = 180;
constexpr int32_t kThetaFirst = -45;  // degrees, of row 0
constexpr int32_t kMaxRhoBins = 32768;

// The row that a gradient direction falls into.
constexpr int32_t theta_row(uint8_t direction) {
  const int32_t degrees = ((direction & 127) * 45 + 16) / 32;  // 0..179
  return (degrees - kThetaFirst) % kThetaBins;
}

// Cells that hold every line through an image whose rectified pixels lie within reach of the principal point.
inline int32_t rho_bins_for(double reach) { return 2 * (static_cast<int32_t>(reach) + 2); }

// Clears acc (kThetaBins rows of rho_bins, at most kMaxRhoBins) and lets every edgel vote in the rows up to spread
// (0..45) from its own.  A cell gets one vote a pixel at most, from a band one pixel wide through an image of at most
// 4096 x 4096: 16 bits hold it.  Votes beyond rho_bins are left out.
void hough_vote(const rvdnav_edgel* edgels, uint32_t n, int32_t rho_bins, int32_t spread, const Kernels& kernels,
                uint16_t* acc);

}  // namespace rvdnav
