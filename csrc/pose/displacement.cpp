#include "pose/displacement.hpp"

#include <algorithm>
#include <cmath>

namespace rvdnav {
namespace {

// The least that the lines are taken to show, and the largest that is still noise rather than a wrong model, pixels.
constexpr double kLeast = 0.02 / 1.4142135623730951;
constexpr double kLargest = 0.7;
constexpr int32_t kBisections = 12;

double excess(const double* squares, const double* known, int32_t n, double sigma, double freedom) {
  double sum = 0.0;
  for (int32_t i = 0; i < n; ++i) sum += squares[i] / (known[i] + sigma * sigma);
  return sum - freedom;
}

// The sigma at which the sum of squares / (known + sigma^2) is the freedom, within its bounds.
double consistent_sigma(const double* squares, const double* known, int32_t n, double freedom) {
  double low = kLeast, high = kLargest;
  if (!(excess(squares, known, n, low, freedom) > 0.0)) return low;
  for (int32_t i = 0; i < kBisections; ++i) {
    const double middle = std::sqrt(low * high);
    (excess(squares, known, n, middle, freedom) > 0.0 ? low : high) = middle;
  }
  return high;
}

}  // namespace

void whitening_of(const OffsetTilt& known, const Displacement& displacement, double* whitening) {
  const double offset_variance = known.offset + displacement.offset * displacement.offset;
  const double slope = known.mixed / offset_variance;
  const double tilt_sigma = std::sqrt(known.tilt + displacement.tilt * displacement.tilt - slope * known.mixed);
  whitening[0] = whitening[1] = 0.5 / std::sqrt(offset_variance);
  whitening[2] = -0.5 * (1.0 + slope) / tilt_sigma;
  whitening[3] = 0.5 * (1.0 - slope) / tilt_sigma;
}

Displacement shown_displacement(const OffsetTilt* known, const double* distances, const double* weights, int32_t n,
                                const double* leverage, double* scratch) {
  double* squares = scratch;
  double* variances = scratch + n;
  double total = 0.0;
  for (int32_t i = 0; i < n; ++i) {
    const double offset = 0.5 * (distances[2 * i] + distances[2 * i + 1]);
    squares[i] = weights[i] * offset * offset;
    variances[i] = known[i].offset;
    total += weights[i];
  }
  const double offset_sigma = consistent_sigma(squares, variances, n, std::max(total - leverage[0], 1.0));
  for (int32_t i = 0; i < n; ++i) {
    const double offset = 0.5 * (distances[2 * i] + distances[2 * i + 1]);
    const double tilt = 0.5 * (distances[2 * i + 1] - distances[2 * i]);
    // What the tilt has beyond what the offset tells of it.
    const double slope = known[i].mixed / (known[i].offset + offset_sigma * offset_sigma);
    squares[i] = weights[i] * (tilt - slope * offset) * (tilt - slope * offset);
    variances[i] = known[i].tilt - slope * known[i].mixed;
  }
  return {offset_sigma, consistent_sigma(squares, variances, n, std::max(total - leverage[1], 1.0))};
}

}  // namespace rvdnav
