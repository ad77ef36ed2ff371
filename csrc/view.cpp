#include "view.hpp"

#include "apexes.hpp"
#include "bars.hpp"
#include "edge.hpp"
#include "hough.hpp"
#include "peaks.hpp"
#include "rectify.hpp"
#include "refit.hpp"
#include "smooth.hpp"
#include "stage_clock.hpp"
#include "thin.hpp"
#include "track.hpp"

namespace rvdnav {
namespace {

constexpr uint8_t kSaturated = 250;  // grey level

void measure_light(const GreyView& image, const Kernels& kernels, rvdnav_view_result* result) {
  uint64_t sum = 0;
  uint32_t saturated = 0;
  for (int32_t y = 0; y < image.height; ++y) kernels.light_row(image.row(y), image.width, kSaturated, &sum, &saturated);
  const uint64_t pixels = static_cast<uint64_t>(image.width) * static_cast<uint64_t>(image.height);
  result->mean_grey = static_cast<double>(sum) / static_cast<double>(pixels);
  result->saturated_permille = static_cast<uint32_t>(uint64_t{1000} * saturated / pixels);
}

uint32_t count_edges(const uint32_t* bits, int32_t words) {
  uint32_t n = 0;
  for (int32_t i = 0; i < words; ++i) n += static_cast<uint32_t>(__builtin_popcount(bits[i]));
  return n;
}

// Segments, bars and proposals: what this view alone can say of an unknown bracket.
void search_view(Context& c, int32_t camera, Workspace& work, StageClock& clock, rvdnav_view_result* result) {
  hough_vote(work.edgels, work.edgel_count, c.config.hough_rho_bins, c.config.hough_spread, *c.kernels,
             work.accumulator);
  uint32_t total = 0;
  work.peak_count = hough_peaks(work.accumulator, c.config.hough_rho_bins, c.config.peak_min_votes, *c.kernels,
                                work.peaks, static_cast<uint32_t>(c.config.max_peaks), &total);
  if (total > work.peak_count) result->limits |= RVDNAV_LIMIT_PEAKS;
  if (c.config.hough_rho_bins < rho_bins_for(c.reach)) result->limits |= RVDNAV_LIMIT_RHO;
  clock.lap(RVDNAV_STAGE_HOUGH);

  const SegmentLimits segment_limits = {static_cast<double>(c.config.segment_min_length),
                                        static_cast<double>(c.config.segment_max_gap)};
  work.segment_count =
      extract_segments(work.edgels, work.edgel_count, work.peaks, work.peak_count, segment_limits, work.lines,
                       work.segments, static_cast<uint32_t>(c.config.max_segments), &total);
  if (total > work.segment_count) result->limits |= RVDNAV_LIMIT_SEGMENTS;
  for (uint32_t i = 0; i < work.segment_count; ++i)
    work.segment_lines[i] = Line2::from_angle(work.segments[i].rho, work.segments[i].theta);
  work.bar_count = find_bars(work.segments, work.segment_count, bar_limits(c), work.bars,
                             static_cast<uint32_t>(c.config.max_bars), &total);
  if (total > work.bar_count) result->limits |= RVDNAV_LIMIT_BARS;
  clock.lap(RVDNAV_STAGE_LINES);

  work.proposal_count = 0;
  if (c.has_target) {
    const ViewBars bars = {{work.segments, work.segment_lines, work.segment_count}, work.bars, work.bar_count};
    bool limited = false;
    work.proposal_count =
        propose_brackets(rect_rig(c.rig), c.model, camera, bars, {c.config.range_min, c.config.range_max},
                         static_cast<uint32_t>(c.config.max_hypotheses), work.proposals, kMaxProposals, &limited);
    if (limited) result->limits |= RVDNAV_LIMIT_HYPOTHESES;
  }
  clock.lap(RVDNAV_STAGE_BRACKET);
}

}  // namespace

BarLimits bar_limits(const Context& c) {
  // The bars' widths at the ends of the range gate; tilt makes them narrower, and the outer halves of blur bring two
  // edges nearer than two pixels together.
  double narrow = 1e9;
  double wide = 0.0;
  for (double width : c.model.bar_width) {
    narrow = width < narrow ? width : narrow;
    wide = width > wide ? width : wide;
  }
  const double least = 0.4 * c.rig.focal_rect * narrow / c.config.range_max;
  return {least > 2.0 ? least : 2.0, 1.2 * c.rig.focal_rect * wide / c.config.range_min, max_slenderness(c.model)};
}

void track_lines(Context& c, int32_t camera, const GreyView& image, const rvdnav_window* windows, uint32_t window_count,
                 rvdnav_view_result* result) {
  StageClock clock(c.config, result->stage_ns);
  Workspace& work = c.work[camera];
  rvdnav_peak peaks[RVDNAV_EDGES];
  hough_track(work.edgels, work.edgel_count, c.config.hough_spread, windows, window_count, work.track, peaks);
  clock.lap(RVDNAV_STAGE_HOUGH);
  result->line_mask = 0;
  for (uint32_t i = 0; i < window_count; ++i) {
    if (peaks[i].votes == 0) continue;
    rvdnav_line& line = result->lines[windows[i].edge];
    line = {};
    line.found = 1;
    line.votes = peaks[i].votes;
    line.rho = peaks[i].rho_q8 / 256.0;
    line.theta = peaks[i].theta_q8 * (kPi / (180.0 * 256.0));
    line.t_min = windows[i].t_min;
    line.t_max = windows[i].t_max;
    refit_line(c.rig, camera, image, c.config.blur_sigma, &line);
    result->line_mask |= 1U << windows[i].edge;
  }
  result->apex_mask = intersect_lines(result->lines, result->apexes);
  clock.lap(RVDNAV_STAGE_REFIT);
}

rvdnav_status process_view(Context& c, int32_t camera, const GreyView& image, const rvdnav_window* windows,
                           uint32_t window_count, rvdnav_view_result* result) {
  *result = {};
  result->struct_size = sizeof(*result);
  Workspace& work = c.work[camera];
  StageClock clock(c.config, result->stage_ns);
  measure_light(image, *c.kernels, result);
  smooth(image, *c.kernels, work.smooth_row, work.smoothed);
  clock.lap(RVDNAV_STAGE_SMOOTH);
  detect_edges(work.smoothed, c.rig.width, c.rig.height, c.threshold, *c.kernels, work.edge, work.edge_bits);
  clock.lap(RVDNAV_STAGE_EDGES);
  filter_edges(work.edge_bits, c.rig.width, c.rig.height, c.config.edge_min_run, *c.kernels, work.bit_scratch);
  thin(work.edge_bits, c.rig.width, c.rig.height, *c.kernels, work.thin);
  result->edge_count = count_edges(work.edge_bits, edge_row_words(c.rig.width) * c.rig.height);
  clock.lap(RVDNAV_STAGE_THIN);
  uint32_t total = 0;
  work.edgel_count = rectify_gradients(work.edge_bits, work.smoothed, c.rig.width, c.rig.height, c.lens[camera],
                                       *c.kernels, work.edgels, static_cast<uint32_t>(c.config.max_edgels), &total);
  if (total > work.edgel_count) result->limits |= RVDNAV_LIMIT_EDGELS;
  clock.lap(RVDNAV_STAGE_RECTIFY);

  work.peak_count = work.segment_count = work.bar_count = work.proposal_count = 0;
  if (window_count > 0) {
    track_lines(c, camera, image, windows, window_count, result);
  } else {
    search_view(c, camera, work, clock, result);
  }
  result->peak_count = work.peak_count;
  result->segment_count = work.segment_count;
  result->bar_count = work.bar_count;
  return RVDNAV_OK;
}

}  // namespace rvdnav
