// The eight neighbours of a pixel in packed edge bits.
#pragma once

#include "types.hpp"

namespace rvdnav {

// Bit 0: east, then on by 45 degrees towards +y: south-east, south, ... north-east.  Outside the image: 0.
inline uint32_t neighbours_of(const uint32_t* bits, int32_t w, int32_t h, int32_t x, int32_t y) {
  const int32_t words = edge_row_words(w);
  // Bits x-1, x, x+1 of row y in bits 0, 1, 2.
  const auto three = [&](int32_t row) -> uint32_t {
    if (row < 0 || row >= h) return 0;
    const uint32_t* p = bits + static_cast<ptrdiff_t>(row) * words + x / 32;
    const int32_t b = x % 32;
    const uint32_t before = b > 0 ? p[0] >> (b - 1) : (p[0] << 1) | (x > 0 ? p[-1] >> 31 : 0);
    const uint32_t after = b == 31 && x / 32 + 1 < words ? (p[1] & 1) << 2 : 0;
    return (before & 7) | after;
  };
  const uint32_t a = three(y - 1), b = three(y), c = three(y + 1);
  return (b >> 2) | (c >> 2) << 1 | (c >> 1 & 1) << 2 | (c & 1) << 3 | (b & 1) << 4 | (a & 1) << 5 | (a >> 1 & 1) << 6 |
         (a >> 2) << 7;
}

// The same neighbours of 32 pixels at once: bit i of n[j] is neighbour j of pixel i of word k in row y.
struct Around {
  uint32_t n[8];
};

inline Around neighbours_of_word(const uint32_t* bits, int32_t words, int32_t h, int32_t k, int32_t y) {
  struct Three {
    uint32_t west, middle, east;
  };
  const auto three = [&](int32_t row) -> Three {
    if (row < 0 || row >= h) return {0, 0, 0};
    const uint32_t* p = bits + static_cast<ptrdiff_t>(row) * words + k;
    return {p[0] << 1 | (k > 0 ? p[-1] >> 31 : 0), p[0], p[0] >> 1 | (k + 1 < words ? p[1] << 31 : 0)};
  };
  const Three a = three(y - 1), b = three(y), c = three(y + 1);
  return {{b.east, c.east, c.middle, c.west, b.west, a.west, a.middle, a.east}};
}

}  // namespace rvdnav
