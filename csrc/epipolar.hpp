// Stage 8: row-wise epipolar correlation of grey windows in rectified coordinates.
#pragma once

#include <cstdint>

#include "rvdnav/rvdnav.h"
#include "types.hpp"

namespace rvdnav {

constexpr int32_t kMaxHalfWindow = 10;   // pixels
constexpr int32_t kMaxRowTolerance = 4;  // pixels
constexpr int32_t kMaxDisparities = 512;
constexpr int32_t kMaxWindow = 2 * kMaxHalfWindow + 1;

// Grey values of one band of rows, Q4, as the search runs over it.
struct MatchScratch {
  static constexpr int32_t kRows = kMaxWindow + 2 * kMaxRowTolerance;
  static constexpr int32_t kColumns = kMaxDisparities + kMaxWindow + 1;
  int16_t window[kMaxWindow * kMaxWindow];
  int16_t band[kRows * kColumns];
  float score[kMaxDisparities];
};

// Matches each left point (x, y, bar) along its row of the right view within the range gate: the best normalised
// cross-correlation over the row tolerance, its sub-pixel disparity, and accepted where the score, its lead over every
// rival, the way back from right to left and the disparity gradient against accepted neighbours on the same bar all
// pass.  p_W is left for the triangulation.
void correlate_rows(const rvdnav_config& config, const rvdnav_rig& rig, const GreyView& left, const GreyView& right,
                    MatchScratch& scratch, rvdnav_match* matches, uint32_t count);

}  // namespace rvdnav
