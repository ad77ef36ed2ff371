// Stage 1: smoothing.
#pragma once

#include "kernels/kernels.hpp"
#include "types.hpp"

namespace rvdnav {

// 3x3 binomial (1 2 1) x (1 2 1) / 16, rounded, borders replicated.  scratch: width + 2.  out: rows of width bytes, not
// overlapping the input.
void smooth(const GreyView& in, const Kernels& kernels, uint16_t* scratch, uint8_t* out);

}  // namespace rvdnav
