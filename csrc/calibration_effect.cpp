#include "calibration_effect.hpp"

#include <algorithm>
#include <cmath>

#include "lens.hpp"
#include "math/elementary.hpp"

namespace rvdnav {
namespace {

constexpr int32_t kTerms = kEffectDegree + 1;
constexpr int32_t kPoints = 16;  // along a line
constexpr double kLeastSpread = 1e-9;

// Of the two ends: how much each polynomial's shift counts in the shift across the line there.
struct EndWeights {
  double term[kTerms][kTerms][2];
};

void chebyshev(double x, double* terms) {
  terms[0] = 1.0;
  terms[1] = x;
  for (int32_t k = 2; k < kTerms; ++k) terms[k] = 2.0 * x * terms[k - 1] - terms[k - 2];
}

// A pixel's place in an image scaled to [-1, 1], at the border for those beyond it.
bool scaled(double pixel, int32_t length, double* place) {
  const double value = 2.0 * pixel / (length - 1) - 1.0;
  *place = std::isnan(value) ? 0.0 : std::clamp(value, -1.0, 1.0);
  return std::abs(value) <= 1.0;
}

// The points that the line was measured at: positions along it, places in the image, and weights whose sum is 1.
struct LinePoints {
  double t[kPoints], x[kPoints], y[kPoints], weight[kPoints];
};

LinePoints line_points(const rvdnav_rig& rig, const rvdnav_measured_line& line, const double* normal,
                       const double* end_t) {
  LinePoints points;
  int32_t on_image = 0;
  for (int32_t m = 0; m < kPoints; ++m) {
    const double t = end_t[0] + (m + 0.5) / kPoints * (end_t[1] - end_t[0]);
    double u = 0.0, v = 0.0;
    rect_to_raw(rig, line.camera, line.rho * normal[0] - t * normal[1], line.rho * normal[1] + t * normal[0], &u, &v);
    const bool along = scaled(u, rig.width, &points.x[m]), down = scaled(v, rig.height, &points.y[m]);
    points.t[m] = t;
    points.weight[m] = along && down ? 1.0 : 0.0;
    on_image += along && down ? 1 : 0;
  }
  const bool enough = on_image >= 2;
  for (double& weight : points.weight) weight = enough ? weight / on_image : 1.0 / kPoints;
  return points;
}

EndWeights end_weights(const LinePoints& points, const double* end_t) {
  double middle = 0.0, spread = 0.0;
  for (int32_t m = 0; m < kPoints; ++m) middle += points.weight[m] * points.t[m];
  for (int32_t m = 0; m < kPoints; ++m) {
    spread += points.weight[m] * (points.t[m] - middle) * (points.t[m] - middle);
  }
  spread = std::max(spread, kLeastSpread);
  EndWeights ends = {};
  for (int32_t m = 0; m < kPoints; ++m) {
    const double lever = points.weight[m] * (points.t[m] - middle) / spread;
    const double first = points.weight[m] + (end_t[0] - middle) * lever;
    const double second = points.weight[m] + (end_t[1] - middle) * lever;
    double along[kTerms], down[kTerms];
    chebyshev(points.x[m], along);
    chebyshev(points.y[m], down);
    for (int32_t i = 0; i < kTerms; ++i) {
      for (int32_t j = 0; j < kTerms; ++j) {
        ends.term[i][j][0] += first * along[i] * down[j];
        ends.term[i][j][1] += second * along[i] * down[j];
      }
    }
  }
  return ends;
}

}  // namespace

void calibration_derivatives(const rvdnav_rig& rig, const rvdnav_calibration_effect& effect,
                             const rvdnav_measured_line& line, double* derivatives, ptrdiff_t stride) {
  const auto p = static_cast<ptrdiff_t>(effect.parameters);
  const double normal[2] = {math::cos(line.theta), math::sin(line.theta)};
  const double* centers = effect.centers + 3 * p * line.camera;
  double end_t[2];
  for (int32_t end = 0; end < 2; ++end) {
    const double* point = line.ends[end];
    const double scale = rig.focal_rect / point[2], x = scale * point[0], y = scale * point[1];
    end_t[end] = normal[0] * y - normal[1] * x;
    const double across = normal[0] * x + normal[1] * y;
    // A camera that moves one way shows the point moved the other way.
    const double gradient[3] = {scale * normal[0], scale * normal[1], -across / point[2]};
    double* out = derivatives + end * stride;
    for (ptrdiff_t k = 0; k < p; ++k) {
      out[k] = across / rig.focal_rect * effect.focal[k] - gradient[0] * centers[k] - gradient[1] * centers[p + k] -
               gradient[2] * centers[2 * p + k];
    }
  }
  const EndWeights weights = end_weights(line_points(rig, line, normal, end_t), end_t);
  const double* shift = effect.shift + 2 * p * kTerms * kTerms * line.camera;
  for (const auto& row : weights.term) {
    for (const double* weight : row) {
      for (ptrdiff_t k = 0; k < p; ++k) {
        const double across = normal[0] * shift[k] + normal[1] * shift[p + k];
        derivatives[k] -= weight[0] * across;
        derivatives[stride + k] -= weight[1] * across;
      }
      shift += 2 * p;
    }
  }
}

}  // namespace rvdnav
