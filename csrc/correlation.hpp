// Correlation coefficients in integers.
#pragma once

#include <stdint.h>

namespace rvdnav {

// The largest integer whose square is at most v.
inline uint32_t square_root(uint64_t v) {
  uint64_t root = 0;
  for (uint64_t bit = uint64_t{1} << 31; bit != 0; bit >>= 1) {
    const uint64_t tried = root + bit;
    if (tried * tried <= v) root = tried;
  }
  return static_cast<uint32_t>(root);
}

// cross / sqrt(a b) in Q15, -1 .. 1, for sums of products; 0 where a or b is.
inline int32_t correlation_q15(int64_t cross, int64_t a, int64_t b) {
  if (a <= 0 || b <= 0) return 0;
  // Both below 2^31, so that their product fits; shifted by an even number together, which the root halves.
  int32_t shift_a = 0, shift_b = 0;
  while ((a >> shift_a) >= (int64_t{1} << 31)) ++shift_a;
  while ((b >> shift_b) >= (int64_t{1} << 31)) ++shift_b;
  if ((shift_a + shift_b) % 2 != 0) ++(shift_a > shift_b ? shift_a : shift_b);
  const uint32_t root = square_root(static_cast<uint64_t>(a >> shift_a) * static_cast<uint64_t>(b >> shift_b));
  if (root == 0) return 0;
  const int64_t scaled = cross / (int64_t{1} << (shift_a + shift_b) / 2) * 32768 / static_cast<int64_t>(root);
  return static_cast<int32_t>(scaled > 32768 ? 32768 : scaled < -32768 ? -32768 : scaled);
}

}  // namespace rvdnav
