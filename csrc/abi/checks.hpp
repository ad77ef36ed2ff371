// Ranges that several calls hold their arguments to.
#pragma once

#include <cmath>

#include "arena.hpp"
#include "rvdnav/rvdnav.h"

namespace rvdnav {

// Beyond these no measurement lies; squares and products of such numbers are finite.
constexpr double kLargestSigma = 1e6;   // pixels
constexpr double kLargestLength = 1e6;  // metres
constexpr double kLargestFocal = 1e6;   // pixels
constexpr double kLargestEntry = 1e30;  // of covariances, information and derivatives
constexpr uint32_t kMaxCalibrationParameters = 64;

// Written so that a NaN fails.
inline bool all_within(const double* values, size_t count, double bound) {
  for (size_t i = 0; i < count; ++i) {
    if (!(std::abs(values[i]) <= bound)) return false;
  }
  return true;
}

bool is_rotation(const double* R);
bool are_cameras_usable(const rvdnav_pose_cameras& cameras);
rvdnav_status check_effect(const rvdnav_calibration_effect& effect, int32_t cameras);

// Work memory of a call.
inline rvdnav_status check_memory(const void* memory, size_t size, size_t needed) {
  if (memory == nullptr) return RVDNAV_ERROR_NULL;
  return size < needed || reinterpret_cast<uintptr_t>(memory) % kAlignment != 0 ? RVDNAV_ERROR_MEMORY : RVDNAV_OK;
}

}  // namespace rvdnav
