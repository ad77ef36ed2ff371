#include "refit.hpp"

#include <algorithm>
#include <cmath>

#include "math/elementary.hpp"

namespace rvdnav {
namespace {

constexpr uint32_t kMaxSamples = 64;
constexpr uint32_t kMinSamples = 6;
constexpr double kMinAgreement = 0.4;  // of the samples
constexpr double kHalfWidth = 3.5;     // pixels: reach of the search around the peak's line
constexpr double kEndMargin = 2.0;     // pixels left out at both ends, where other edges come in
constexpr double kTukey = 4.685;
constexpr double kScaleFloor = 0.05;  // pixels
constexpr int32_t kRounds = 8;

// Offset and slope of the samples against the line, by iteratively reweighted least squares.
struct StraightFit {
  double offset, slope;
  double var_offset, var_slope, cov;
  double rms;
  double used;
};

double median(double* values, uint32_t n) {
  std::nth_element(values, values + n / 2, values + n);
  return values[n / 2];
}

bool fit_straight(const double* t, const double* y, uint32_t n, StraightFit* fit) {
  double scratch[kMaxSamples];
  std::copy(y, y + n, scratch);
  double offset = median(scratch, n);
  double slope = 0.0;
  for (int32_t round = 0; round < kRounds; ++round) {
    for (uint32_t i = 0; i < n; ++i) scratch[i] = std::abs(y[i] - offset - slope * t[i]);
    const double scale = std::max(1.4826 * median(scratch, n), kScaleFloor);
    double sw = 0, st = 0, stt = 0, sy = 0, sty = 0;
    for (uint32_t i = 0; i < n; ++i) {
      const double z = (y[i] - offset - slope * t[i]) / (kTukey * scale);
      const double w = std::abs(z) < 1.0 ? (1.0 - z * z) * (1.0 - z * z) : 0.0;
      sw += w;
      st += w * t[i];
      stt += w * t[i] * t[i];
      sy += w * y[i];
      sty += w * t[i] * y[i];
    }
    const double det = sw * stt - st * st;
    if (!(det > 1e-9 * sw * stt)) return false;
    offset = (stt * sy - st * sty) / det;
    slope = (sw * sty - st * sy) / det;
    if (round + 1 < kRounds) continue;
    double square = 0.0;
    for (uint32_t i = 0; i < n; ++i) {
      const double r = y[i] - offset - slope * t[i];
      const double z = r / (kTukey * scale);
      const double w = std::abs(z) < 1.0 ? (1.0 - z * z) * (1.0 - z * z) : 0.0;
      square += w * r * r;
    }
    const double variance = square / std::max(sw - 2.0, 1.0);
    *fit = {offset, slope, variance * stt / det, variance * sw / det, -variance * st / det, std::sqrt(variance), sw};
  }
  return true;
}

}  // namespace

void refit_line(const rvdnav_rig& rig, int32_t camera, const GreyView& image, double blur_sigma, rvdnav_line* line) {
  const Line2 found = Line2::from_angle(line->rho, line->theta);
  const double length = line->t_max - line->t_min - 2.0 * kEndMargin;
  if (length < kMinSamples) return;
  // Walked towards falling t, so that the profiles' normal (-dy, dx) is the line's.
  const Eigen::Vector2d a = found.at(line->t_max - kEndMargin);
  const Eigen::Vector2d b = found.at(line->t_min + kEndMargin);
  const rvdnav_model_edge edge = {a.x(), a.y(), b.x(), b.y(), 0.0, 0.0, 0, 0};
  const ProfileSettings settings = {kHalfWidth, std::max(length / kMaxSamples, 1.0), blur_sigma};
  rvdnav_edge_sample samples[kMaxSamples];
  const ProfileCount count = measure_edge(rig, camera, image, edge, 0, settings, samples, kMaxSamples);
  const uint32_t n = std::min(count.found, kMaxSamples);
  if (n < kMinSamples) return;
  double t[kMaxSamples];
  double y[kMaxSamples];
  const double middle = 0.5 * (line->t_min + line->t_max);
  for (uint32_t i = 0; i < n; ++i) {
    t[i] = (0.5 - samples[i].fraction) * length;
    y[i] = samples[i].offset;
  }
  StraightFit fit;
  if (!fit_straight(t, y, n, &fit) || fit.used < std::max<double>(kMinSamples, kMinAgreement * n)) return;

  // Points of the new line are n rho + d t + n (offset + slope (t - middle)): its normal turns by -atan(slope).
  const double turn = -math::atan(fit.slope);
  const Eigen::Vector2d on_line = found.at(middle) + fit.offset * found.normal;
  bool flipped = false;
  line->theta = normalized_theta(line->theta + turn, &flipped);
  const Line2 fitted = Line2::from_angle(0.0, line->theta);
  line->rho = fitted.normal.dot(on_line);
  // d rho = d offset - middle * d slope and d theta = -d slope; across the end of the theta range rho changes its sign.
  const double sign = flipped ? -1.0 : 1.0;
  line->covariance[0] = fit.var_offset - 2.0 * middle * fit.cov + middle * middle * fit.var_slope;
  line->covariance[1] = line->covariance[2] = sign * (middle * fit.var_slope - fit.cov);
  line->covariance[3] = fit.var_slope;
  line->samples = n;
  line->rms = fit.rms;
  line->refitted = 1;
  if (flipped) {
    const double t_min = line->t_min;
    line->t_min = -line->t_max;
    line->t_max = -t_min;
  }
}

}  // namespace rvdnav
