// Stage 2: adaptive Sobel edges.
//
// Threshold.  The eye sees a step when it exceeds a fixed amount in the dark, where its own noise rules, and a fixed
// fraction of the surrounding brightness by day (Weber); dazzled, it sees less and less.  A camera behaves alike, save
// that near saturation its steps shrink with the room left below white, so there the threshold grows at a quarter of
// the rate.  With the local mean m, in grey levels of step:
//     threshold = max(floor, weber * min(m, knee) + weber / 4 * max(m - knee, 0)).
//
// Magnitude.  The largest of |Sobel| in the directions 0, 45, 90 and 135 degrees of the smoothed image.  A sharp step
// of s grey levels, smoothed by the 3x3 binomial, gives 3 s where it lies along the rows or the columns and 3.125 s
// where it lies along a diagonal.
#pragma once

#include "kernels/kernels.hpp"
#include "types.hpp"

namespace rvdnav {

constexpr int32_t kMagnitudePerStep = 3;

// floor: grey levels; weber_q8: fraction of the local mean; knee: grey level; all 0..255.
ThresholdCurve make_threshold_curve(int32_t floor, int32_t weber_q8, int32_t knee);

// The rows in work.
struct EdgeScratch {
  int16_t* magnitude;  // 3 * edge_scratch_row(width)
  uint8_t* code;       // 3 * edge_scratch_row(width)
};

constexpr size_t edge_scratch_row(size_t width) { return width + 2 * kRowMargin; }

// Edge pixels: the magnitude is at least the threshold and a ridge along the direction of the largest response.  bits:
// edge_row_words(w) words a row.  Nearer than two pixels to the border there are none.
void detect_edges(const uint8_t* smoothed, int32_t w, int32_t h, const ThresholdCurve& threshold,
                  const Kernels& kernels, const EdgeScratch& scratch, uint32_t* bits);

// Direction of the gradient (256 to the turn, from +x towards +y, towards brighter) at the edge pixels, none of which
// is on the image's border; the others' stay as they are.
void edge_directions(const uint8_t* smoothed, int32_t w, int32_t h, const Kernels& kernels, const uint32_t* bits,
                     uint8_t* direction);

}  // namespace rvdnav
