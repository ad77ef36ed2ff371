// What the calibration's errors do.
#include <cmath>

#include "abi/abi.hpp"
#include "abi/checks.hpp"
#include "calibration_effect.hpp"

using namespace rvdnav;

namespace {

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
  RVDNAV_TRY(check_effect(*effect, rig->camera_count));
  if (effect->parameters == 0 || line_count == 0) return RVDNAV_OK;
  if (lines == nullptr || derivatives == nullptr) return RVDNAV_ERROR_NULL;
  for (uint32_t i = 0; i < line_count; ++i) {
    if (!is_usable(*rig, lines[i])) return RVDNAV_ERROR_ARGUMENT;
    const auto p = static_cast<ptrdiff_t>(effect->parameters);
    calibration_derivatives(*rig, *effect, lines[i], derivatives + 2 * i * p, p);
  }
  return RVDNAV_OK;
}
