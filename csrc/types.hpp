// Small types that every stage shares.
#pragma once

#include <stddef.h>
#include <stdint.h>

namespace rvdnav {

// An 8-bit grey image that somebody else owns; stride in bytes.
struct GreyView {
  const uint8_t* data;
  int32_t width;
  int32_t height;
  int32_t stride;

  const uint8_t* row(int32_t y) const { return data + static_cast<ptrdiff_t>(y) * stride; }
};

// Words in a row of packed edge bits: bit x % 32 of word x / 32.
constexpr int32_t edge_row_words(int32_t width) { return (width + 31) / 32; }

}  // namespace rvdnav
