// Smoothed images at halving resolutions, and the Laplacian of Gaussian of each.
#pragma once

#include <stddef.h>
#include <stdint.h>

namespace rvdnav {

constexpr int32_t kPyramidLevels = 5;

constexpr int32_t halved(int32_t size) { return (size + 1) / 2; }

// One resolution of one view.  Pixel i of a level is pixel 2 i of the finer one below it.
struct PyramidLevel {
  int32_t width, height;
  uint16_t* grey;      // Q8
  uint16_t* smoothed;  // Q8, by the 5x5 binomial (variance 1)
  int16_t* laplacian;  // of the smoothed image smoothed again (variance 2), 3/4 of a grey level per square pixel, Q8
};

// From level.grey the other two.  row: scratch of width + 4 values; plane: scratch of width * height values.
void filter_level(const PyramidLevel& level, uint16_t* row, uint16_t* plane);

// The coarser level's grey image from the finer one's smoothed image.
void halve(const PyramidLevel& fine, const PyramidLevel& coarse);

}  // namespace rvdnav
