#include "edge.hpp"

#include "angle.hpp"

namespace rvdnav {
namespace {

int32_t local_mean(const uint8_t* p, ptrdiff_t stride) {
  const uint8_t* a = p - stride;
  const uint8_t* c = p + stride;
  return (a[-1] + a[0] + a[1] + p[-1] + p[0] + p[1] + c[-1] + c[0] + c[1]) / 9;
}

uint8_t gradient_direction(const uint8_t* p, ptrdiff_t stride) {
  const uint8_t* a = p - stride;
  const uint8_t* c = p + stride;
  const int32_t gx = (a[1] + 2 * p[1] + c[1]) - (a[-1] + 2 * p[-1] + c[-1]);
  const int32_t gy = (c[-1] + 2 * c[0] + c[1]) - (a[-1] + 2 * a[0] + a[1]);
  return binary_angle(gx, gy);
}

// Threshold and direction of one row's candidates, which are few.
void keep_candidates(const uint8_t* candidate, const int16_t* magnitude, const uint8_t* smoothed, int32_t w,
                     const ThresholdCurve& threshold, uint32_t* bits, uint8_t* direction) {
  for (int32_t base = 0; base < w; base += 32) {
    const int32_t end = base + 32 < w ? base + 32 : w;
    uint32_t any = 0;
    for (int32_t x = base; x < end; ++x) any |= candidate[x];
    if (any == 0) continue;
    uint32_t word = 0;
    for (int32_t x = base; x < end; ++x) {
      if (candidate[x] == 0) continue;
      if (magnitude[x] < threshold.value[local_mean(smoothed + x, w)]) continue;
      word |= uint32_t{1} << (x - base);
      direction[x] = gradient_direction(smoothed + x, w);
    }
    bits[base / 32] = word;
  }
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
  return curve;
}

void detect_edges(const uint8_t* smoothed, int32_t w, int32_t h, const ThresholdCurve& threshold,
                  const Kernels& kernels, EdgeScratch& scratch, uint32_t* bits, uint8_t* direction) {
  const ptrdiff_t words = edge_row_words(w);
  for (ptrdiff_t i = 0; i < words * h; ++i) bits[i] = 0;
  for (ptrdiff_t i = 0; i < static_cast<ptrdiff_t>(w) * h; ++i) direction[i] = 0;
  if (w < 5 || h < 5) return;

  // The curve never falls, so its first value is a bound that needs no local mean.  A flat patch is no edge even if
  // every threshold is 0.
  const int16_t minimum = static_cast<int16_t>(threshold.value[0] > 0 ? threshold.value[0] : 1);
  const auto row = [&](int32_t y) { return smoothed + static_cast<ptrdiff_t>(y) * w; };
  const auto magnitude = [&](int32_t y) { return scratch.magnitude + static_cast<ptrdiff_t>(y % 3) * w; };
  const auto sector = [&](int32_t y) { return scratch.sector + static_cast<ptrdiff_t>(y % 3) * w; };
  for (int32_t y = 1; y < h - 1; ++y) {
    kernels.gradient_row(row(y - 1), row(y), row(y + 1), w, magnitude(y), sector(y));
    const int32_t ridge = y - 1;  // the newest row with magnitudes on both sides
    if (ridge < 2) continue;
    kernels.ridge_row(magnitude(ridge - 1), magnitude(ridge), magnitude(ridge + 1), sector(ridge), w, minimum,
                      scratch.candidate);
    keep_candidates(scratch.candidate, magnitude(ridge), row(ridge), w, threshold, bits + ridge * words,
                    direction + static_cast<ptrdiff_t>(ridge) * w);
  }
}

}  // namespace rvdnav
