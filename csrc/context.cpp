#include "context.hpp"

#include <algorithm>

#include "types.hpp"

namespace rvdnav {
namespace {

void lay_out_view(const Context& c, Arena& arena, Workspace& work) {
  const rvdnav_config& config = c.config;
  const rvdnav_rig& rig = c.rig;
  const auto width = static_cast<size_t>(rig.width);
  const auto height = static_cast<size_t>(rig.height);
  const size_t pixels = width * height;
  const size_t words = static_cast<size_t>(edge_row_words(rig.width)) * height;
  const auto edgels = static_cast<size_t>(config.max_edgels);
  arena.take(&work.smooth_row, width + 2);
  arena.take(&work.edge.magnitude, 3 * edge_scratch_row(width));
  arena.take(&work.edge.code, 3 * edge_scratch_row(width));
  arena.take(&work.smoothed, pixels);
  arena.take(&work.edge_bits, words);
  arena.take(&work.bit_scratch, words);
  arena.take(&work.thin.deletable, words / height);
  arena.take(&work.thin.empty, words / height);
  arena.take(&work.thin.stale, height);
  arena.take(&work.edgels, edgels);
  arena.take(&work.accumulator, static_cast<size_t>(kThetaBins) * static_cast<size_t>(config.hough_rho_bins));
  work.track.max_shear = track_shear(c.reach);
  arena.take(&work.track.votes, track_votes(work.track.max_shear));
  arena.take(&work.peaks, static_cast<size_t>(config.max_peaks));
  arena.take(&work.lines.order, edgels);
  arena.take(&work.lines.members, edgels);
  arena.take(&work.segments, static_cast<size_t>(config.max_segments));
  arena.take(&work.segment_lines, static_cast<size_t>(config.max_segments));
  arena.take(&work.bars, static_cast<size_t>(config.max_bars));
  arena.take(&work.proposals, kMaxProposals);
}

// Edge pixels that there is room for: in textured images a tenth of the pixels, in large ones less, as edges are lines.
int32_t default_edgels(const rvdnav_rig& rig) { return std::max<int32_t>(65536, rig.width * rig.height / 16); }

}  // namespace

void lay_out(const rvdnav_config& config, const rvdnav_rig& rig, Arena& arena, Context* context) {
  Context& c = *context;
  c.config = config;
  c.rig = rig;
  c.reach = 0.0;
  for (int32_t camera = 0; camera < rig.camera_count; ++camera)
    c.reach = std::max(c.reach, std::min(rectified_reach(rig, camera), kMaxRect));
  if (config.hough_rho_bins == 0) c.config.hough_rho_bins = rho_bins_for(c.reach);
  if (config.max_edgels == 0) c.config.max_edgels = default_edgels(rig);
  c.disparities = allowed_disparities(config, rig, c.reach);
  for (int32_t camera = 0; camera < rig.camera_count; ++camera) {
    arena.take(&c.lens_nodes[camera], map_length(rig.width, rig.height));
    lay_out_view(c, arena, c.work[camera]);
  }
  arena.take(&c.proposals, RVDNAV_CAMERAS * kMaxProposals);
  const auto disparities = static_cast<size_t>(c.disparities.count);
  arena.take(&c.match.window, kMaxWindow * kMaxWindow);
  arena.take(&c.match.band, (disparities + kMaxWindow) * kMaxBandRows);
  arena.take(&c.match.score, disparities);
}

rvdnav_status build(Context* context) {
  Context& c = *context;
  c.kernels = select_kernels(c.config.isa);
  if (c.kernels == nullptr) return RVDNAV_ERROR_ISA;
  c.threshold = make_threshold_curve(c.config.edge_floor, c.config.edge_weber_q8, c.config.edge_knee);
  for (int32_t camera = 0; camera < c.rig.camera_count; ++camera) {
    if (!build_lens_map(c.rig, camera, c.lens_nodes[camera], &c.lens[camera])) return RVDNAV_ERROR_CALIBRATION;
  }
  return RVDNAV_OK;
}

void set_target(const rvdnav_target* target, Context* context) {
  context->has_target = target != nullptr;
  if (target == nullptr) return;
  context->target = *target;
  context->model = make_bracket_model(*target);
}

}  // namespace rvdnav
