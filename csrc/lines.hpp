// From peaks of Hough space to straight segments with ends: the line fit.
#pragma once

#include <cstdint>

#include "rvdnav/rvdnav.h"

namespace rvdnav {

// Edgels in the order of their gradient's direction, so that a line visits only those that can lie on it.
constexpr int32_t kDirectionBuckets = 64;

struct LineScratch {
  uint32_t* order;                               // max_edgels
  uint32_t bucket_start[kDirectionBuckets + 1];  // into order
  struct Member {
    float t;
    uint32_t edgel;
  } * members;  // max_edgels
};

// Whether two segments of about the same direction have their bright side on the same side.
bool same_polarity(const rvdnav_segment& a, const rvdnav_segment& b);

struct SegmentLimits {
  double min_length;  // pixels
  double max_gap;     // pixels
};

// Runs of edgels of one polarity along each peak's line, each fitted by total least squares; a run found from several
// peaks is kept once.  Sorted by support.  Returns the number written; *total counts all found, which may be more.
uint32_t extract_segments(const rvdnav_edgel* edgels, uint32_t edgel_count, const rvdnav_peak* peaks,
                          uint32_t peak_count, const SegmentLimits& limits, LineScratch& scratch,
                          rvdnav_segment* segments, uint32_t capacity, uint32_t* total);

}  // namespace rvdnav
