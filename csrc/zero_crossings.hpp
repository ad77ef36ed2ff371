// Zero crossings of the Laplacian of Gaussian along the rows of one level.
#pragma once

#include "pyramid.hpp"
#include "resample.hpp"

namespace rvdnav {

struct Crossing {
  int32_t x_q8;    // column
  int32_t slope;   // of the Laplacian along the row, its units a pixel; negative where grey levels rise
  int32_t gx, gy;  // gradient of the smoothed image, grey levels over two pixels, Q8; gx is not 0
};

// The crossings of a level, row by row, in the order of x.
struct CrossingRows {
  Crossing* crossings;  // max_crossings(width) * height
  uint32_t* row_start;  // height + 1

  uint32_t begin(int32_t y) const { return row_start[y]; }
  uint32_t end(int32_t y) const { return row_start[y + 1]; }
};

// Of a row; smoothed noise has one in about four pixels.
constexpr int32_t max_crossings(int32_t width) { return width / 3 + 1; }

// A level of a view, and its crossings.
struct LevelView {
  int32_t level;  // 0: the full resolution
  PyramidLevel image;
  const RowSpan* spans;  // of the full resolution's rows
  int32_t full_height;   // as many
  CrossingRows rows;
};

// Columns of a row that the raw image covers.
RowSpan level_span(const LevelView& view, int32_t y);

constexpr int32_t kMaxRun = 7;

// Fills view.rows with the crossings whose edge takes at most kMaxRun columns for a row and whose slope is at least
// min_slope.
void find_crossings(const LevelView& view, int32_t min_slope);

}  // namespace rvdnav
