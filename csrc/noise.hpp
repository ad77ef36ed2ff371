// The white noise of an image.
#pragma once

#include "types.hpp"

namespace rvdnav {

// Twice the median of |a - 2 b + c| over every third row, where a, b, c are the second differences 1 -2 1 along three
// neighbouring rows: of even many values, the sum of the two in the middle.  Planes and straight edges along the axes
// leave these at zero, and the others most of them.  0 for images of fewer than three rows or columns.
uint32_t noise_median_q1(const GreyView& image);

}  // namespace rvdnav
