#include "sampling.hpp"

#include <algorithm>
#include <cmath>

#include <Eigen/Core>

namespace rvdnav {
namespace {

// Corners blend two edges: this much of an edge's ends is not sampled, but for a tenth in its middle.
constexpr double kEndMargin = 3.0;  // pixels
constexpr double kMostMargin = 0.45;
constexpr double kReach = 1e4;  // pixels; an edge whose ends lie farther out crosses no image

struct Placed {
  Eigen::Vector2d start, span;
  bool usable;
};

// False for a NaN.
bool is_near(const Eigen::Vector2d& point) { return std::abs(point.x()) <= kReach && std::abs(point.y()) <= kReach; }

Placed place(const rvdnav_rig& rig, const rvdnav_seen_edge& edge, double shortest) {
  const auto projected = [&](const double* p) -> Eigen::Vector2d {
    return {rig.focal_rect * p[0] / p[2], rig.focal_rect * p[1] / p[2]};
  };
  Eigen::Vector2d start = projected(edge.ends[0]), end = projected(edge.ends[1]);
  const Eigen::Vector2d along = end - start;
  const Eigen::Vector2d normal = Eigen::Vector2d(-along.y(), along.x()) / std::max(along.norm(), 1e-9);
  start += edge.offset[0] * normal;
  end += edge.offset[1] * normal;
  const bool near = is_near(start) && is_near(end);
  return {start, end - start, near && (end - start).norm() >= shortest};
}

// The part between the corners, as a model edge.
rvdnav_model_edge inner_part(const Placed& placed, const rvdnav_seen_edge& edge) {
  const double margin = std::min(kEndMargin / std::max(placed.span.norm(), 1e-9), kMostMargin);
  const Eigen::Vector2d a = placed.start + margin * placed.span, b = a + (1.0 - 2.0 * margin) * placed.span;
  const double face = std::abs(edge.face) <= kReach ? edge.face : 0.0;
  return {a.x(), a.y(), b.x(), b.y(), face, edge.blur, edge.polarity, 0};
}

}  // namespace

uint32_t sample_edges(const rvdnav_rig& rig, const GreyView* images, const rvdnav_seen_edge* edges, uint32_t edge_count,
                      double shortest, ProfileSettings settings, rvdnav_edge_sample* samples,
                      rvdnav_edge_coverage* coverage) {
  double longest[RVDNAV_CAMERAS] = {};
  for (uint32_t i = 0; i < edge_count; ++i) {
    const Placed placed = place(rig, edges[i], shortest);
    double& length = longest[edges[i].camera];
    if (placed.usable) length = std::max(length, placed.span.norm());
  }
  uint32_t written = 0;
  for (uint32_t i = 0; i < edge_count; ++i) {
    const int32_t camera = edges[i].camera;
    const Placed placed = place(rig, edges[i], shortest);
    coverage[i] = {placed.usable ? 1 : 0, 0};
    if (!placed.usable) continue;
    settings.step = std::max(1.0, longest[camera] / kMostProfiles);
    const ProfileCount count = measure_edge(rig, camera, images[camera], inner_part(placed, edges[i]),
                                            static_cast<int32_t>(i), settings, samples + written, kMostProfiles);
    coverage[i].profiles = static_cast<int32_t>(count.on_image);
    written += count.found;
  }
  return written;
}

}  // namespace rvdnav
