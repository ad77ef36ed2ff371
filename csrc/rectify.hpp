// Edge pixels in rectified coordinates.
#pragma once

#include "kernels/kernels.hpp"
#include "lens_map.hpp"

namespace rvdnav {

// Maps every edge pixel that has a ray, and its gradient's direction, row by row.  The lens turns directions, so the
// direction is taken from the mapped tangent.  Returns the number written, at most capacity (the first ones); *total
// counts all.
uint32_t rectify_edges(const uint32_t* bits, const uint8_t* direction, int32_t w, int32_t h, const LensMap& map,
                       const Kernels& kernels, rvdnav_edgel* out, uint32_t capacity, uint32_t* total);

// The same with the gradient's direction in the smoothed image; every edge pixel lies two or more from the image's
// border.
uint32_t rectify_gradients(const uint32_t* bits, const uint8_t* smoothed, int32_t w, int32_t h, const LensMap& map,
                           const Kernels& kernels, rvdnav_edgel* out, uint32_t capacity, uint32_t* total);

}  // namespace rvdnav
