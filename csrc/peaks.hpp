// Local maxima of Hough space.
//
// An edge that lies far along its line (at t) is a ridge across the rows that runs aside by t * 1 degree a row; where
// that is more than the suppression's half-width, one edge can have several peaks, in neighbouring rows.  Nothing in
// the accumulator tells them from other edges close by, so they are all given: the line fit, which knows the edgels,
// keeps one.
#pragma once

#include "hough.hpp"

namespace rvdnav {

// Half-widths of the suppression: parallel edges 3 pixels apart stay apart.
constexpr int32_t kPeakCells = 2;
constexpr int32_t kPeakRows = 3;

// Maxima of at least min_votes; votes are those in a cell and half of those in the cells beside it along rho, over
// which an edge between two cells spreads.  rho and theta by parabolas.  Returns the number written: the best capacity
// ones, sorted by votes descending, then by theta and rho; *total counts all.
uint32_t hough_peaks(const uint16_t* acc, int32_t rho_bins, int32_t min_votes, const Kernels& kernels, rvdnav_peak* out,
                     uint32_t capacity, uint32_t* total);

}  // namespace rvdnav
