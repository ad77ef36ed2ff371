// What the extern "C" functions share: the opaque type and the checks of their arguments.
#pragma once

#include "context.hpp"
#include "rvdnav/rvdnav.h"
#include "status.hpp"
#include "types.hpp"

struct rvdnav_context {
  uint64_t magic;
  const rvdnav_context* self;  // tells a context that was copied elsewhere, whose arrays are not its own
  rvdnav::Context context;
};

namespace rvdnav {

constexpr double kFar = 16384.0;  // pixels; beyond every image

constexpr uint64_t kContextMagic = 0x7276646e61760000ULL + RVDNAV_ABI_VERSION;

// abi/arguments.cpp
rvdnav_status check_context(const rvdnav_context* context);
rvdnav_status check_camera(const rvdnav_context* context, int32_t camera);  // the context, too
rvdnav_status check_image(const rvdnav_context* context, const rvdnav_image* image);
// No bits are set beyond the image's width.
rvdnav_status check_edge_bits(const rvdnav_context* context, const uint32_t* edge_bits);
rvdnav_status check_edgels(const rvdnav_context* context, const rvdnav_edgel* edgels, uint32_t count);
rvdnav_status check_peaks(const rvdnav_peak* peaks, uint32_t count);
rvdnav_status check_segments(const rvdnav_segment* segments, uint32_t count);
rvdnav_status check_windows(const rvdnav_window* windows, uint32_t count);

// abi/validate.cpp
rvdnav_status validate(const rvdnav_config& config);
rvdnav_status validate(const rvdnav_rig& rig);
rvdnav_status validate(const rvdnav_target& target);

inline GreyView grey_view(const rvdnav_image& image) { return {image.data, image.width, image.height, image.stride}; }

// The end of a stage that found total items: count says so, and RVDNAV_ERROR_CAPACITY that they didn't fit.
inline rvdnav_status finish_list(uint32_t written, uint32_t total, uint32_t* count) {
  *count = total;
  return written < total ? RVDNAV_ERROR_CAPACITY : RVDNAV_OK;
}

}  // namespace rvdnav
