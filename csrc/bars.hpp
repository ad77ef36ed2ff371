// Bars: near-parallel segments with a small distance between them.
#pragma once

#include <cstdint>

#include "rvdnav/rvdnav.h"

namespace rvdnav {

struct BarLimits {
  double min_width;  // pixels
  double max_width;
  double max_slenderness;  // seen length over width
};

// Pairs of segments that can be the two sides of one bar, best first: sides of opposite polarity (a bar lighter or
// darker than both neighbours) before equal ones, then by the length seen on both sides.  Returns the number written;
// *total counts all found.
uint32_t find_bars(const rvdnav_segment* segments, uint32_t segment_count, const BarLimits& limits, rvdnav_bar* bars,
                   uint32_t capacity, uint32_t* total);

}  // namespace rvdnav
