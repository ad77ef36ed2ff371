#include "smooth.hpp"

namespace rvdnav {

void smooth(const GreyView& in, const Kernels& kernels, uint16_t* scratch, uint8_t* out) {
  for (int32_t y = 0; y < in.height; ++y) {
    const uint8_t* above = in.row(y > 0 ? y - 1 : 0);
    const uint8_t* below = in.row(y < in.height - 1 ? y + 1 : y);
    kernels.smooth_row(above, in.row(y), below, in.width, scratch, out + static_cast<ptrdiff_t>(y) * in.width);
  }
}

}  // namespace rvdnav
