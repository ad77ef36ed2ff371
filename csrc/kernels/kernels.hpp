// The row kernels of the image stages and the choice of their instruction set.
//
// Two sources give the same bits: plain loops (row_kernels.inl, edgel_kernels.inl) for processors without lanes, and
// vector code (lane_kernels.inl, edgel_lanes.inl) over a few primitives that each instruction set's own file defines.
#pragma once

#include <stdint.h>

#include "lens_map.hpp"
#include "rvdnav/rvdnav.h"

namespace rvdnav {

// Least magnitude of an edge by the local mean.
struct ThresholdCurve {
  uint16_t value[256];
  // What it is made of: value[mean] is the least m with m >= least and 1024 * m >= weber * (mean + 3 * min(mean,
  // knee)).
  int16_t least;
  int16_t weber;
  int16_t knee;
};

// The borders from which thinning takes a layer at a time.
enum class Borders { kNorthWest, kSouthEast };

// Edge pixels as the kernels take them: x in the low half, y in the high half of a word.
constexpr uint32_t packed_pixel(int32_t x, int32_t y) {
  return static_cast<uint32_t>(y) << 16 | static_cast<uint32_t>(x);
}

// At most so many at a time; lists of them are readable up to the next multiple of 8, with any pixels of the image.
constexpr int32_t kPixelBatch = 128;

// Values before and after a row of magnitudes, and a multiple of its codes, that ridge_row may read.
constexpr int32_t kRowMargin = 64;

struct Kernels {
  int32_t isa;  // RVDNAV_ISA_...

  // One row of the 3x3 binomial from three rows of the input; scratch: width + 2.
  void (*smooth_row)(const uint8_t* above, const uint8_t* centre, const uint8_t* below, int32_t width,
                     uint16_t* scratch, uint8_t* out);

  // For the inner pixels of a row the largest of the four Sobel responses, and a code: 1 + its sector (0: 0 degrees,
  // 1: 45, 2: 90, 3: 135) where the magnitude reaches the threshold, else 0.  Both are 0 for the first and the last
  // pixel.
  void (*gradient_row)(const uint8_t* above, const uint8_t* centre, const uint8_t* below, int32_t width,
                       const ThresholdCurve& threshold, int16_t* magnitude, uint8_t* code);

  // Bit x is set where the code isn't 0 and the magnitude is a ridge along the sector's direction.  The magnitudes have
  // kRowMargin values of any kind before and after them, the codes kRowMargin zeros after them.
  void (*ridge_row)(const int16_t* above, const int16_t* centre, const int16_t* below, const uint8_t* code,
                    int32_t width, uint32_t* bits);

  // Of packed pixels, those that thinning may delete first, judged by the neighbours of now: simple, no end, and on
  // one of the borders given.  Returns whether there are any.
  bool (*deletable_row)(const uint32_t* above, const uint32_t* centre, const uint32_t* below, int32_t words,
                        Borders borders, uint32_t* deletable);

  // Adds to a row's kept pixels those that touch kept ones of the row above, and through these others of their
  // word; returns whether any pixels are left.
  bool (*touching_row)(const uint32_t* pixels, const uint32_t* kept_above, int32_t words, uint32_t* kept);

  // Adds the row's grey levels, and how many are at least the level given, to the two sums.
  void (*light_row)(const uint8_t* row, int32_t width, uint8_t level, uint64_t* sum, uint32_t* bright);

  // Of 32 cells of Hough space, those whose doubled votes (a cell's twice and those of both beside it) are at least the
  // least, 65535 at most, and not fewer than those of both beside it; doubled votes beyond 65535 count as equal.  Reads
  // two cells before and after them.
  uint32_t (*high_cells)(const uint16_t* cells, uint16_t least);

  // Directions of the gradient, 256 to the turn, at count pixels that lie two or more from the image's border.  levels:
  // kPixelBatch.
  void (*gradient_levels)(const uint8_t* smoothed, int32_t width, const uint32_t* pixels, int32_t count,
                          uint8_t* levels);

  // Edgels of count pixels with their directions, without those that have no ray; returns how many.  out: kPixelBatch.
  int32_t (*rectify_pixels)(const LensMap& map, const uint32_t* pixels, const uint8_t* levels, int32_t count,
                            rvdnav_edgel* out);

  // The votes of hough_vote, into an accumulator that is already cleared.
  void (*vote)(const rvdnav_edgel* edgels, uint32_t count, int32_t rho_bins, int32_t spread, uint16_t* accumulator);
};

// The kernels of an instruction set (RVDNAV_ISA_...; AUTO takes the best that this processor has), null if this build
// or this processor lacks it.
const Kernels* select_kernels(int32_t isa);

}  // namespace rvdnav
