// Stage 8: row-wise epipolar correlation of grey windows in rectified coordinates.
#pragma once

#include <cstdint>

#include "rvdnav/rvdnav.h"
#include "types.hpp"

namespace rvdnav {

constexpr int32_t kMaxHalfWindow = 10;   // pixels
constexpr int32_t kMaxRowTolerance = 4;  // pixels
constexpr int32_t kMaxWindow = 2 * kMaxHalfWindow + 1;

// Grey values of one band of rows, Q4, as the search runs over it.
struct MatchScratch {
  int16_t* window;  // kMaxWindow^2
  int16_t* band;    // kMaxBandRows rows of the disparities and kMaxWindow more
  float* score;     // of the disparities
};

constexpr int32_t kMaxBandRows = kMaxWindow + 2 * kMaxRowTolerance;

// The whole disparities that the range gate allows, of views that reach (pixels from the principal point) so far.
struct Disparities {
  int32_t first, count;
};

Disparities allowed_disparities(const rvdnav_config& config, const rvdnav_rig& rig, double reach);

// Matches each left point (x, y, bar) along its row of the right view among the disparities: the best normalised
// cross-correlation over the row tolerance, its sub-pixel disparity, and accepted where the score, its lead over every
// rival, the way back from right to left and the disparity gradient against accepted neighbours on the same bar all
// pass.  p_W is left for the triangulation.
void correlate_rows(const rvdnav_config& config, const rvdnav_rig& rig, const Disparities& disparities,
                    const GreyView& left, const GreyView& right, const MatchScratch& scratch, rvdnav_match* matches,
                    uint32_t count);

}  // namespace rvdnav
