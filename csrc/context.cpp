#include "context.hpp"

#include "types.hpp"

namespace rvdnav {
namespace {

void lay_out_view(const rvdnav_config& config, const rvdnav_rig& rig, Arena& arena, Workspace& work) {
  const auto width = static_cast<size_t>(rig.width);
  const auto height = static_cast<size_t>(rig.height);
  const size_t pixels = width * height;
  const size_t words = static_cast<size_t>(edge_row_words(rig.width)) * height;
  const auto edgels = static_cast<size_t>(config.max_edgels);
  arena.take(&work.smooth_row, width + 2);
  arena.take(&work.edge.magnitude, 3 * width);
  arena.take(&work.edge.sector, 3 * width);
  arena.take(&work.edge.candidate, width);
  arena.take(&work.smoothed, pixels);
  arena.take(&work.edge_bits, words);
  arena.take(&work.bit_scratch, words);
  arena.take(&work.direction, pixels);
  arena.take(&work.edgels, edgels);
  arena.take(&work.accumulator, static_cast<size_t>(kThetaBins) * static_cast<size_t>(config.hough_rho_bins));
  arena.take(&work.track, 1);
  arena.take(&work.peaks, static_cast<size_t>(config.max_peaks));
  arena.take(&work.lines.order, edgels);
  arena.take(&work.lines.members, edgels);
  arena.take(&work.segments, static_cast<size_t>(config.max_segments));
  arena.take(&work.segment_lines, static_cast<size_t>(config.max_segments));
  arena.take(&work.bars, static_cast<size_t>(config.max_bars));
  arena.take(&work.proposals, kMaxProposals);
}

}  // namespace

void lay_out(const rvdnav_config& config, const rvdnav_rig& rig, Arena& arena, Context* context) {
  for (int32_t camera = 0; camera < rig.camera_count; ++camera) {
    arena.take(&context->lens_nodes[camera], map_length(rig.width, rig.height));
    lay_out_view(config, rig, arena, context->work[camera]);
  }
  arena.take(&context->proposals, RVDNAV_CAMERAS * kMaxProposals);
  arena.take(&context->match, 1);
}

rvdnav_status build(const rvdnav_config& config, const rvdnav_rig& rig, const rvdnav_target* target, Context* context) {
  Context& c = *context;
  c.config = config;
  c.rig = rig;
  c.kernels = select_kernels(config.isa);
  if (c.kernels == nullptr) return RVDNAV_ERROR_ISA;
  c.threshold = make_threshold_curve(config.edge_floor, config.edge_weber_q8, config.edge_knee);
  c.has_target = target != nullptr;
  if (target != nullptr) {
    c.target = *target;
    c.model = make_bracket_model(*target);
  }
  for (int32_t camera = 0; camera < rig.camera_count; ++camera) {
    if (!build_lens_map(rig, camera, c.lens_nodes[camera], &c.lens[camera])) return RVDNAV_ERROR_CALIBRATION;
  }
  return RVDNAV_OK;
}

}  // namespace rvdnav
