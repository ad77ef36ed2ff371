#include "zero_crossings.hpp"

#include "integers.hpp"

namespace rvdnav {
namespace {

constexpr int32_t kMargin = 4;  // columns from the end of a span: what the filters reach

// Where the cubic through f[-1], f[0], f[1], f[2] crosses zero between 0 and 1, Q8; f[0] and f[1] differ in sign.
int32_t cubic_zero_q8(const int16_t* f) {
  const int64_t a = -f[-1] + 3 * f[0] - 3 * f[1] + f[2];
  const int64_t b = 3 * f[-1] - 6 * f[0] + 3 * f[1];
  const int64_t c = -2 * f[-1] - 3 * f[0] + 6 * f[1] - f[2];
  const int64_t d = 6 * f[0];
  const bool positive = f[0] > 0;
  int32_t low = 0, high = 256;
  while (high - low > 1) {
    const int64_t t = (low + high) / 2;
    const int64_t value = ((a * t + b * 256) * t + c * 65536) * t + d * 16777216;
    ((value > 0) == positive ? low : high) = static_cast<int32_t>(t);
  }
  return high;
}

}  // namespace

RowSpan level_span(const LevelView& view, int32_t y) {
  const int32_t row = y << view.level;
  const RowSpan span = view.spans[row < view.full_height ? row : view.full_height - 1];
  const int32_t up = (1 << view.level) - 1;
  return {static_cast<int16_t>((span.begin + up) >> view.level), static_cast<int16_t>((span.end + up) >> view.level)};
}

void find_crossings(const LevelView& view, int32_t min_slope) {
  const PyramidLevel& image = view.image;
  const CrossingRows& out = view.rows;
  uint32_t count = 0;
  for (int32_t y = 0; y < image.height; ++y) {
    out.row_start[y] = count;
    if (y == 0 || y == image.height - 1) continue;
    const RowSpan span = level_span(view, y);
    const ptrdiff_t offset = static_cast<ptrdiff_t>(y) * image.width;
    const int16_t* row = image.laplacian + offset;
    const uint16_t* smoothed = image.smoothed + offset;
    const uint32_t limit = count + static_cast<uint32_t>(max_crossings(image.width));
    for (int32_t x = span.begin + kMargin; x < span.end - kMargin - 1 && count < limit; ++x) {
      if ((row[x] > 0) == (row[x + 1] > 0)) continue;
      const int32_t slope = row[x + 1] - row[x];
      if (magnitude(slope) < min_slope) continue;
      const int32_t t_q8 = cubic_zero_q8(row + x);
      const uint16_t* s = smoothed + x + (t_q8 >= 128 ? 1 : 0);
      const int32_t gx = s[1] - s[-1], gy = s[image.width] - s[-image.width];
      // The edge must rise where the Laplacian falls: other crossings are of smooth shading.
      if (gx == 0 || (gx > 0) != (slope < 0) || magnitude(gy) > kMaxRun * magnitude(gx)) continue;
      out.crossings[count++] = {256 * x + t_q8, slope, gx, gy};
    }
  }
  out.row_start[image.height] = count;
}

}  // namespace rvdnav
