// The row kernels of the image stages and the choice of their instruction set.
//
// One plain source (row_kernels.inl) is compiled once per instruction set; every build of it gives the same bits.
#pragma once

#include <stdint.h>

namespace rvdnav {

struct Kernels {
  int32_t isa;  // RVDNAV_ISA_...

  // One row of the 3x3 binomial from three rows of the input; scratch: width + 2.
  void (*smooth_row)(const uint8_t* above, const uint8_t* centre, const uint8_t* below, int32_t width,
                     uint16_t* scratch, uint8_t* out);

  // The largest of the four Sobel responses and its sector (0: 0 degrees, 1: 45, 2: 90, 3: 135) for the inner pixels of
  // a row; the magnitude of the first and the last pixel is 0.
  void (*gradient_row)(const uint8_t* above, const uint8_t* centre, const uint8_t* below, int32_t width,
                       int16_t* magnitude, uint8_t* sector);

  // candidate[x] = 255 where the magnitude is at least minimum and a ridge along the sector's direction, else 0; two
  // pixels at each end are always 0.
  void (*ridge_row)(const int16_t* above, const int16_t* centre, const int16_t* below, const uint8_t* sector,
                    int32_t width, int16_t minimum, uint8_t* candidate);
};

// The kernels of an instruction set (RVDNAV_ISA_...; AUTO takes the best that this processor has), null if this build
// or this processor lacks it.
const Kernels* select_kernels(int32_t isa);

}  // namespace rvdnav
