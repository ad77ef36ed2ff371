// A rectified image by resampling the raw one: the rows of both views are epipolar lines.
#pragma once

#include "rect_map.hpp"
#include "types.hpp"

namespace rvdnav {

// Columns begin .. end - 1 of a rectified row that the raw image covers.
struct RowSpan {
  int16_t begin, end;
};

// Grey levels in Q8 by cubic interpolation (Catmull-Rom).  Where the raw image doesn't reach its border is repeated,
// and spans (height of them) leave it out.  u, v: scratch of width values each.
void resample(const GreyView& raw, const RectMap& map, int32_t* u, int32_t* v, uint16_t* out, RowSpan* spans);

}  // namespace rvdnav
