// Stages 7 to 9, each by itself.
#include <algorithm>
#include <cmath>
#include <limits>

#include "abi/abi.hpp"
#include "epipolar.hpp"
#include "profile.hpp"
#include "sampling.hpp"
#include "triangulate.hpp"

using namespace rvdnav;

namespace {

constexpr double kMinStep = 0.05;         // pixels; bounds the number of profiles
constexpr double kMaxBlur = 10.0;         // pixels
constexpr uint32_t kMostSeen = 1U << 16;  // edges in a call

bool is_near(double value) { return std::abs(value) <= kFar; }  // false for a NaN

bool is_usable(const rvdnav_model_edge& edge) {
  return is_near(edge.x0) && is_near(edge.y0) && is_near(edge.x1) && is_near(edge.y1) && is_near(edge.face) &&
         edge.blur >= 0.0 && edge.blur <= kMaxBlur && edge.polarity >= -1 && edge.polarity <= 1;
}

// Written so that a NaN fails.
bool is_usable(const rvdnav_rig& rig, const rvdnav_seen_edge& edge) {
  for (int32_t end = 0; end < 2; ++end) {
    const double* p = edge.ends[end];
    if (!(std::isfinite(p[0]) && std::isfinite(p[1]) && p[2] > 0.0 && std::abs(edge.offset[end]) <= kFar)) return false;
  }
  return edge.camera >= 0 && edge.camera < rig.camera_count && std::isfinite(edge.face) && edge.blur >= 0.0 &&
         edge.blur <= kMaxBlur && edge.polarity >= -1 && edge.polarity <= 1;
}

bool is_half_width(double value) { return value >= 1.0 && value <= kMaxHalfWidth; }

rvdnav_status check_stereo(const rvdnav_context* context) {
  RVDNAV_TRY(check_context(context));
  return context->context.rig.camera_count == RVDNAV_CAMERAS ? RVDNAV_OK : RVDNAV_ERROR_ARGUMENT;
}

}  // namespace

rvdnav_status rvdnav_measure_edges(rvdnav_context* context, int32_t camera, const rvdnav_image* image,
                                   const rvdnav_model_edge* edges, uint32_t edge_count, double half_width, double step,
                                   double blur_sigma, rvdnav_edge_sample* samples, uint32_t capacity, uint32_t* count) {
  RVDNAV_TRY(check_camera(context, camera));
  RVDNAV_TRY(check_image(context, image));
  if (count == nullptr || (edges == nullptr && edge_count > 0) || (samples == nullptr && capacity > 0)) {
    return RVDNAV_ERROR_NULL;
  }
  // Written so that a NaN fails.
  if (!(is_half_width(half_width) && step >= kMinStep && step <= kFar && blur_sigma >= 0.0 && blur_sigma <= kMaxBlur)) {
    return RVDNAV_ERROR_ARGUMENT;
  }
  const Context& c = context->context;
  const ProfileSettings settings = {half_width, step, blur_sigma > 0.0 ? blur_sigma : c.config.blur_sigma};
  uint32_t written = 0;
  uint32_t total = 0;
  for (uint32_t i = 0; i < edge_count; ++i) {
    if (!is_usable(edges[i])) return RVDNAV_ERROR_ARGUMENT;
    const ProfileCount found = measure_edge(c.rig, camera, grey_view(*image), edges[i], static_cast<int32_t>(i),
                                            settings, samples + written, capacity - written);
    written += std::min(found.found, capacity - written);
    total += found.found;
  }
  return finish_list(written, total, count);
}

rvdnav_status rvdnav_sample_edges(rvdnav_context* context, const rvdnav_image* left, const rvdnav_image* right,
                                  const rvdnav_seen_edge* edges, uint32_t edge_count, double half_width,
                                  double shortest, rvdnav_edge_sample* samples, uint32_t capacity, uint32_t* count,
                                  rvdnav_edge_coverage* coverage) {
  RVDNAV_TRY(check_context(context));
  const Context& c = context->context;
  if (count == nullptr || (edge_count > 0 && (edges == nullptr || samples == nullptr || coverage == nullptr))) {
    return RVDNAV_ERROR_NULL;
  }
  if (edge_count > kMostSeen || !is_half_width(half_width) || !(shortest >= 0.0)) return RVDNAV_ERROR_ARGUMENT;
  const rvdnav_image* const given[RVDNAV_CAMERAS] = {left, right};
  GreyView images[RVDNAV_CAMERAS] = {};
  for (uint32_t i = 0; i < edge_count; ++i) {
    if (!is_usable(c.rig, edges[i])) return RVDNAV_ERROR_ARGUMENT;
    const rvdnav_image* image = given[edges[i].camera];
    RVDNAV_TRY(check_image(context, image));
    images[edges[i].camera] = grey_view(*image);
  }
  *count = static_cast<uint32_t>(kMostProfiles) * edge_count;
  if (capacity < *count) return RVDNAV_ERROR_CAPACITY;
  const ProfileSettings settings = {half_width, 1.0, c.config.blur_sigma};
  *count = sample_edges(c.rig, images, edges, edge_count, shortest, settings, samples, coverage);
  return RVDNAV_OK;
}

rvdnav_status rvdnav_correlate(rvdnav_context* context, const rvdnav_image* left, const rvdnav_image* right,
                               rvdnav_match* matches, uint32_t match_count) {
  RVDNAV_TRY(check_stereo(context));
  RVDNAV_TRY(check_image(context, left));
  RVDNAV_TRY(check_image(context, right));
  if (matches == nullptr && match_count > 0) return RVDNAV_ERROR_NULL;
  for (uint32_t i = 0; i < match_count; ++i) {
    if (!is_near(matches[i].x) || !is_near(matches[i].y)) return RVDNAV_ERROR_ARGUMENT;
    if (matches[i].bar < -1 || matches[i].bar >= RVDNAV_BARS) return RVDNAV_ERROR_ARGUMENT;
  }
  Context& c = context->context;
  correlate_rows(c.config, c.rig, c.disparities, grey_view(*left), grey_view(*right), c.match, matches, match_count);
  const RectRig rig = rect_rig(c.rig);
  const ProjectionMatrix M_left = projection_matrix(rig, 0);
  const ProjectionMatrix M_right = projection_matrix(rig, 1);
  for (uint32_t i = 0; i < match_count; ++i) {
    rvdnav_match& m = matches[i];
    Eigen::Vector3d p = Eigen::Vector3d::Zero();
    if (m.accepted != 0 && !triangulate(M_left, M_right, {m.x, m.y}, {m.x - m.disparity, m.y}, &p)) m.accepted = 0;
    for (int32_t k = 0; k < 3; ++k) m.p_W[k] = p[k];
  }
  return RVDNAV_OK;
}

rvdnav_status rvdnav_triangulate(rvdnav_context* context, const double* left, const double* right, uint32_t count,
                                 double* p_W) {
  RVDNAV_TRY(check_stereo(context));
  if (count > 0 && (left == nullptr || right == nullptr || p_W == nullptr)) return RVDNAV_ERROR_NULL;
  const RectRig rig = rect_rig(context->context.rig);
  const ProjectionMatrix M_left = projection_matrix(rig, 0);
  const ProjectionMatrix M_right = projection_matrix(rig, 1);
  for (uint32_t i = 0; i < count; ++i) {
    const Eigen::Vector2d left_xy(left[2 * i], left[2 * i + 1]);
    const Eigen::Vector2d right_xy(right[2 * i], right[2 * i + 1]);
    Eigen::Vector3d p;
    if (!triangulate(M_left, M_right, left_xy, right_xy, &p)) p.setConstant(std::numeric_limits<double>::quiet_NaN());
    for (int32_t k = 0; k < 3; ++k) p_W[3 * static_cast<ptrdiff_t>(i) + k] = p[k];
  }
  return RVDNAV_OK;
}
