#include "edge.hpp"

#include "pixel_batches.hpp"

namespace rvdnav {
namespace {

// No edges nearer than two pixels to the ends of a row.
void clear_ends(uint32_t* row, int32_t w) {
  const int32_t ends[] = {0, 1, w - 2, w - 1};
  for (int32_t x : ends) row[x / 32] &= ~(uint32_t{1} << (x % 32));
}

}  // namespace

ThresholdCurve make_threshold_curve(int32_t floor, int32_t weber_q8, int32_t knee) {
  ThresholdCurve curve = {};
  for (int32_t mean = 0; mean < 256; ++mean) {
    const int32_t normal = mean < knee ? mean : knee;
    const int32_t bright = mean - normal;
    const int32_t weber_q10 = weber_q8 * (4 * normal + bright);
    const int32_t step_q10 = weber_q10 > floor * 1024 ? weber_q10 : floor * 1024;
    curve.value[mean] = static_cast<uint16_t>((step_q10 * kMagnitudePerStep + 1023) / 1024);
  }
  // A flat patch is no edge even if every threshold is 0.
  curve.least = static_cast<int16_t>(floor > 0 ? floor * kMagnitudePerStep : 1);
  curve.weber = static_cast<int16_t>(weber_q8 * kMagnitudePerStep);
  curve.knee = static_cast<int16_t>(knee);
  return curve;
}

void detect_edges(const uint8_t* smoothed, int32_t w, int32_t h, const ThresholdCurve& threshold,
                  const Kernels& kernels, const EdgeScratch& scratch, uint32_t* bits) {
  const ptrdiff_t words = edge_row_words(w);
  const auto clear_row = [&](int32_t y) {
    for (ptrdiff_t k = 0; k < words; ++k) bits[y * words + k] = 0;
  };
  for (int32_t y = 0; y < h; ++y) {
    if (h < 5 || w < 5 || y < 2 || y >= h - 2) clear_row(y);
  }
  if (w < 5 || h < 5) return;

  const auto stride = static_cast<ptrdiff_t>(edge_scratch_row(static_cast<size_t>(w)));
  for (ptrdiff_t i = 0; i < 3 * stride; ++i) {
    scratch.magnitude[i] = 0;
    scratch.code[i] = 0;
  }
  const auto row = [&](int32_t y) { return smoothed + static_cast<ptrdiff_t>(y) * w; };
  const auto magnitude = [&](int32_t y) { return scratch.magnitude + y % 3 * stride + kRowMargin; };
  const auto code = [&](int32_t y) { return scratch.code + y % 3 * stride; };
  for (int32_t y = 1; y < h - 1; ++y) {
    kernels.gradient_row(row(y - 1), row(y), row(y + 1), w, threshold, magnitude(y), code(y));
    const int32_t ridge = y - 1;  // the newest row with magnitudes on both sides
    if (ridge < 2) continue;
    kernels.ridge_row(magnitude(ridge - 1), magnitude(ridge), magnitude(ridge + 1), code(ridge), w,
                      bits + ridge * words);
    clear_ends(bits + ridge * words, w);
  }
}

void edge_directions(const uint8_t* smoothed, int32_t w, int32_t h, const Kernels& kernels, const uint32_t* bits,
                     uint8_t* direction) {
  for_each_pixel_batch(bits, w, h, [&](const uint32_t* pixels, int32_t count) {
    uint8_t levels[kPixelBatch];
    kernels.gradient_levels(smoothed, w, pixels, count, levels);
    for (int32_t i = 0; i < count; ++i)
      direction[static_cast<ptrdiff_t>(pixels[i] >> 16) * w + static_cast<ptrdiff_t>(pixels[i] & 0xffff)] = levels[i];
  });
}

}  // namespace rvdnav
