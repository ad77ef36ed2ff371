// Edge pixels from packed bits, in lists as the kernels take them.
#pragma once

#include "kernels/kernels.hpp"
#include "types.hpp"

namespace rvdnav {

// Calls visit(pixels, count) for all set pixels, row by row, at most kPixelBatch at a time.
template <typename Visit>
void for_each_pixel_batch(const uint32_t* bits, int32_t w, int32_t h, Visit visit) {
  const int32_t words = edge_row_words(w);
  uint32_t pixels[kPixelBatch];
  int32_t count = 0;
  const auto hand_over = [&] {
    for (int32_t i = count; i % 8 != 0; ++i) pixels[i] = pixels[0];
    visit(static_cast<const uint32_t*>(pixels), count);
    count = 0;
  };
  for (int32_t y = 0; y < h; ++y) {
    for (int32_t k = 0; k < words; ++k) {
      uint32_t rest = bits[static_cast<ptrdiff_t>(y) * words + k];
      if (rest == 0) continue;
      if (count > kPixelBatch - 32) hand_over();
      for (; rest != 0; rest &= rest - 1) pixels[count++] = packed_pixel(32 * k + __builtin_ctz(rest), y);
    }
  }
  if (count > 0) hand_over();
}

}  // namespace rvdnav
