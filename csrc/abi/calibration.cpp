// What the calibration's errors do.
#include <cmath>

#include "abi/abi.hpp"
#include "calibration_effect.hpp"

using namespace rvdnav;

namespace {

constexpr uint32_t kMaxParameters = 64;

// Written so that a NaN fails.
bool is_usable(const rvdnav_rig& rig, const rvdnav_measured_line& line) {
  const bool in_front = line.ends[0][2] > 0.0 && line.ends[1][2] > 0.0;
  return line.camera >= 0 && line.camera < rig.camera_count && in_front && std::isfinite(line.rho) &&
         std::abs(line.theta) <= kFar;
}

}  // namespace

rvdnav_status rvdnav_calibration_derivatives(const rvdnav_rig* rig, const rvdnav_calibration_effect* effect,
                                             const rvdnav_measured_line* lines, uint32_t line_count,
                                             double* derivatives) {
  if (rig == nullptr || effect == nullptr) return RVDNAV_ERROR_NULL;
  RVDNAV_TRY(validate(*rig));
  if (effect->struct_size != sizeof(rvdnav_calibration_effect)) return RVDNAV_ERROR_STRUCT_SIZE;
  if (effect->parameters > kMaxParameters) return RVDNAV_ERROR_ARGUMENT;
  if (effect->parameters == 0 || line_count == 0) return RVDNAV_OK;
  if (effect->shift == nullptr || effect->focal == nullptr || effect->centers == nullptr || lines == nullptr ||
      derivatives == nullptr) {
    return RVDNAV_ERROR_NULL;
  }
  for (uint32_t i = 0; i < line_count; ++i) {
    if (!is_usable(*rig, lines[i])) return RVDNAV_ERROR_ARGUMENT;
    calibration_derivatives(*rig, *effect, lines[i], derivatives + static_cast<ptrdiff_t>(2) * i * effect->parameters);
  }
  return RVDNAV_OK;
}
