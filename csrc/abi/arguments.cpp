// Checks of what a call on a context is given.
#include <cmath>

#include "abi/abi.hpp"
#include "abi/checks.hpp"
#include "calibration_effect.hpp"

namespace rvdnav {
namespace {

constexpr int32_t kFarthestPeak = 16384 << 8;    // Q8
constexpr int32_t kFullTurnQ8 = 360 << 8;        // degrees
constexpr double kFullTurn = 6.283185307179586;  // radians
constexpr double kRotationError = 1e-3;          // of R R^T from 1

bool within(int32_t value, int32_t bound) { return value >= -bound && value <= bound; }

}  // namespace

bool is_rotation(const double* R) {
  for (int32_t i = 0; i < 3; ++i) {
    for (int32_t j = 0; j < 3; ++j) {
      const double product = R[3 * i] * R[3 * j] + R[3 * i + 1] * R[3 * j + 1] + R[3 * i + 2] * R[3 * j + 2];
      if (!(std::abs(product - (i == j ? 1.0 : 0.0)) <= kRotationError)) return false;
    }
  }
  const double determinant =
      R[0] * (R[4] * R[8] - R[5] * R[7]) - R[1] * (R[3] * R[8] - R[5] * R[6]) + R[2] * (R[3] * R[7] - R[4] * R[6]);
  return determinant > 0.0;
}

bool are_cameras_usable(const rvdnav_pose_cameras& cameras) {
  return cameras.focal > 0.0 && cameras.focal <= kLargestFocal &&
         all_within(cameras.centre[0], 2 * 3, kLargestLength) && is_rotation(cameras.R_rect_W);
}

rvdnav_status check_effect(const rvdnav_calibration_effect& effect, int32_t cameras) {
  if (effect.struct_size != sizeof(effect)) return RVDNAV_ERROR_STRUCT_SIZE;
  if (effect.parameters > kMaxCalibrationParameters) return RVDNAV_ERROR_ARGUMENT;
  if (effect.parameters == 0) return RVDNAV_OK;
  if (effect.shift == nullptr || effect.focal == nullptr || effect.centers == nullptr) return RVDNAV_ERROR_NULL;
  const size_t p = effect.parameters, views = static_cast<size_t>(cameras), terms = kEffectDegree + 1;
  const bool usable = all_within(effect.shift, views * terms * terms * 2 * p, kLargestEntry) &&
                      all_within(effect.focal, p, kLargestEntry) &&
                      all_within(effect.centers, views * 3 * p, kLargestEntry);
  return usable ? RVDNAV_OK : RVDNAV_ERROR_ARGUMENT;
}

rvdnav_status check_context(const rvdnav_context* context) {
  if (context == nullptr) return RVDNAV_ERROR_NULL;
  if (reinterpret_cast<uintptr_t>(context) % kAlignment != 0) return RVDNAV_ERROR_CONTEXT;
  return context->magic == kContextMagic && context->self == context ? RVDNAV_OK : RVDNAV_ERROR_CONTEXT;
}

rvdnav_status check_camera(const rvdnav_context* context, int32_t camera) {
  RVDNAV_TRY(check_context(context));
  return camera >= 0 && camera < context->context.rig.camera_count ? RVDNAV_OK : RVDNAV_ERROR_ARGUMENT;
}

rvdnav_status check_image(const rvdnav_context* context, const rvdnav_image* image) {
  if (image == nullptr || image->data == nullptr) return RVDNAV_ERROR_NULL;
  const rvdnav_rig& rig = context->context.rig;
  const bool fits = image->width == rig.width && image->height == rig.height && image->stride >= image->width;
  return fits ? RVDNAV_OK : RVDNAV_ERROR_IMAGE;
}

rvdnav_status check_edge_bits(const rvdnav_context* context, const uint32_t* edge_bits) {
  if (edge_bits == nullptr) return RVDNAV_ERROR_NULL;
  const rvdnav_rig& rig = context->context.rig;
  const int32_t used = rig.width % 32;
  if (used == 0) return RVDNAV_OK;
  const int32_t words = edge_row_words(rig.width);
  const uint32_t beyond = ~uint32_t{0} << used;
  for (int32_t y = 0; y < rig.height; ++y) {
    if ((edge_bits[static_cast<ptrdiff_t>(y + 1) * words - 1] & beyond) != 0) return RVDNAV_ERROR_ARGUMENT;
  }
  return RVDNAV_OK;
}

rvdnav_status check_edgels(const rvdnav_context* context, const rvdnav_edgel* edgels, uint32_t count) {
  if (edgels == nullptr && count > 0) return RVDNAV_ERROR_NULL;
  return count <= static_cast<uint32_t>(context->context.config.max_edgels) ? RVDNAV_OK : RVDNAV_ERROR_ARGUMENT;
}

rvdnav_status check_peaks(const rvdnav_peak* peaks, uint32_t count) {
  if (peaks == nullptr && count > 0) return RVDNAV_ERROR_NULL;
  for (uint32_t i = 0; i < count; ++i) {
    if (!within(peaks[i].rho_q8, kFarthestPeak) || !within(peaks[i].theta_q8, kFullTurnQ8)) {
      return RVDNAV_ERROR_ARGUMENT;
    }
  }
  return RVDNAV_OK;
}

rvdnav_status check_segments(const rvdnav_segment* segments, uint32_t count) {
  if (segments == nullptr && count > 0) return RVDNAV_ERROR_NULL;
  for (uint32_t i = 0; i < count; ++i) {
    const rvdnav_segment& s = segments[i];
    // Written so that a NaN fails.
    const bool line = std::abs(s.rho) <= kFar && std::abs(s.theta) <= kFullTurn;
    const bool extent = std::abs(s.t_min) <= kFar && std::abs(s.t_max) <= kFar && s.t_min <= s.t_max;
    if (!line || !extent || (s.polarity != 1 && s.polarity != -1)) return RVDNAV_ERROR_ARGUMENT;
  }
  return RVDNAV_OK;
}

rvdnav_status check_windows(const rvdnav_window* windows, uint32_t count) {
  if (windows == nullptr && count > 0) return RVDNAV_ERROR_NULL;
  for (uint32_t i = 0; i < count; ++i) {
    const rvdnav_window& w = windows[i];
    const bool edge = w.edge >= 0 && w.edge < RVDNAV_EDGES && w.polarity >= -1 && w.polarity <= 1;
    // Written so that a NaN fails.
    const bool line = std::abs(w.rho) <= kFar && std::abs(w.theta) <= kFar;
    const bool size = w.half_rho >= 0.0 && w.half_rho <= kFar && w.half_theta >= 0.0 && w.half_theta <= kFar;
    const bool extent = std::abs(w.t_min) <= kFar && std::abs(w.t_max) <= kFar && w.t_min <= w.t_max;
    if (!edge || !line || !size || !extent) return RVDNAV_ERROR_ARGUMENT;
  }
  return RVDNAV_OK;
}

}  // namespace rvdnav
