// Stages 4 and 6: Hough space, each step by itself.
#include "abi/abi.hpp"
#include "hough.hpp"
#include "peaks.hpp"
#include "track.hpp"

using namespace rvdnav;

rvdnav_status rvdnav_hough_vote(rvdnav_context* context, const rvdnav_edgel* edgels, uint32_t edgel_count,
                                uint16_t* accumulator) {
  RVDNAV_TRY(check_context(context));
  RVDNAV_TRY(check_edgels(context, edgels, edgel_count));
  if (accumulator == nullptr) return RVDNAV_ERROR_NULL;
  const rvdnav_config& config = context->context.config;
  hough_vote(edgels, edgel_count, config.hough_rho_bins, config.hough_spread, *context->context.kernels, accumulator);
  return RVDNAV_OK;
}

rvdnav_status rvdnav_hough_peaks(rvdnav_context* context, const uint16_t* accumulator, rvdnav_peak* peaks,
                                 uint32_t capacity, uint32_t* count) {
  RVDNAV_TRY(check_context(context));
  if (accumulator == nullptr || count == nullptr) return RVDNAV_ERROR_NULL;
  if (peaks == nullptr && capacity > 0) return RVDNAV_ERROR_NULL;
  const rvdnav_config& config = context->context.config;
  uint32_t total = 0;
  const uint32_t written = hough_peaks(accumulator, config.hough_rho_bins, config.peak_min_votes,
                                       *context->context.kernels, peaks, capacity, &total);
  return finish_list(written, total, count);
}

rvdnav_status rvdnav_hough_track(rvdnav_context* context, int32_t camera, const rvdnav_edgel* edgels,
                                 uint32_t edgel_count, const rvdnav_window* windows, uint32_t window_count,
                                 rvdnav_peak* peaks) {
  RVDNAV_TRY(check_camera(context, camera));
  RVDNAV_TRY(check_edgels(context, edgels, edgel_count));
  RVDNAV_TRY(check_windows(windows, window_count));
  if (peaks == nullptr && window_count > 0) return RVDNAV_ERROR_NULL;
  Context& c = context->context;
  hough_track(edgels, edgel_count, c.config.hough_spread, windows, window_count, c.work[camera].track, peaks);
  return RVDNAV_OK;
}
