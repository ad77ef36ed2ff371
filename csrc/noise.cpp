#include "noise.hpp"

#include "integers.hpp"

namespace rvdnav {
namespace {

constexpr int32_t kRowStep = 3;
constexpr int32_t kLevels = 8 * 255 + 1;  // values of |(1 -2 1)^T (1 -2 1)|
constexpr int32_t kPiece = 64;            // columns at a time

// Columns x .. x + count - 1 of the mask, whose middle lies one row and column farther.
void mask_row(const GreyView& image, int32_t y, int32_t x, int32_t count, uint16_t* out) {
  const uint8_t *a = image.row(y) + x, *b = image.row(y + 1) + x, *c = image.row(y + 2) + x;
  int16_t down[kPiece + 2];
  for (int32_t i = 0; i < count + 2; ++i) down[i] = static_cast<int16_t>(a[i] - 2 * b[i] + c[i]);
  for (int32_t i = 0; i < count; ++i) {
    const auto both = static_cast<int16_t>(down[i] - 2 * down[i + 1] + down[i + 2]);
    out[i] = static_cast<uint16_t>(both < 0 ? -both : both);
  }
}

// The value that so many of the counted ones lie below, in their order.
uint32_t ranked(const uint32_t* counts, uint32_t rank) {
  uint32_t level = 0;
  for (uint32_t below = counts[0]; below <= rank; below += counts[level]) ++level;
  return level;
}

}  // namespace

uint32_t noise_median_q1(const GreyView& image) {
  uint32_t counts[kLevels] = {};
  uint32_t total = 0;
  for (int32_t y = 0; y + 2 < image.height; y += kRowStep) {
    for (int32_t x = 0; x + 2 < image.width; x += kPiece) {
      uint16_t value[kPiece];
      const int32_t count = smaller(image.width - 2 - x, kPiece);
      mask_row(image, y, x, count, value);
      for (int32_t i = 0; i < count; ++i) ++counts[value[i]];
      total += static_cast<uint32_t>(count);
    }
  }
  return total == 0 ? 0 : ranked(counts, (total - 1) / 2) + ranked(counts, total / 2);
}

}  // namespace rvdnav
