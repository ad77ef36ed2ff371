// Stage 5 up to the bars, each step by itself.
#include "abi/abi.hpp"
#include "bars.hpp"
#include "lines.hpp"
#include "view.hpp"

using namespace rvdnav;

rvdnav_status rvdnav_extract_segments(rvdnav_context* context, int32_t camera, const rvdnav_edgel* edgels,
                                      uint32_t edgel_count, const rvdnav_peak* peaks, uint32_t peak_count,
                                      rvdnav_segment* segments, uint32_t capacity, uint32_t* count) {
  RVDNAV_TRY(check_camera(context, camera));
  RVDNAV_TRY(check_edgels(context, edgels, edgel_count));
  RVDNAV_TRY(check_peaks(peaks, peak_count));
  if (count == nullptr || (segments == nullptr && capacity > 0)) return RVDNAV_ERROR_NULL;
  Context& c = context->context;
  const SegmentLimits limits = {static_cast<double>(c.config.segment_min_length),
                                static_cast<double>(c.config.segment_max_gap)};
  uint32_t total = 0;
  const uint32_t written = extract_segments(edgels, edgel_count, peaks, peak_count, limits, c.work[camera].lines,
                                            segments, capacity, &total);
  return finish_list(written, total, count);
}

rvdnav_status rvdnav_find_bars(rvdnav_context* context, int32_t camera, const rvdnav_segment* segments,
                               uint32_t segment_count, rvdnav_bar* bars, uint32_t capacity, uint32_t* count) {
  RVDNAV_TRY(check_camera(context, camera));
  RVDNAV_TRY(check_segments(segments, segment_count));
  if (count == nullptr || (bars == nullptr && capacity > 0)) return RVDNAV_ERROR_NULL;
  const Context& c = context->context;
  if (!c.has_target) return RVDNAV_ERROR_TARGET;  // its bars' width is what pairs segments
  uint32_t total = 0;
  const uint32_t written = find_bars(segments, segment_count, bar_limits(c), bars, capacity, &total);
  return finish_list(written, total, count);
}
