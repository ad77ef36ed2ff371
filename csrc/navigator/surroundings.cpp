#include "navigator/surroundings.hpp"

#include <algorithm>
#include <cmath>

#include "math/order.hpp"
#include "navigator/constants.hpp"
#include "pose/view_pose.hpp"

namespace rvdnav {
namespace {

// Slope of the grey beside a step, parts of its contrast a pixel, that the model of the blur itself leaves.
constexpr double kSlopeSigma = 0.02;
constexpr double kSharp = 1.05;  // pixels; blur up to which an image is sharp
// Samples from which an edge may have a blur of its own, and by which part it must differ from its view's: within the
// spread that the fit of a step allows for anyway, the difference is noise, and displaces the step.
constexpr int32_t kMinBlurs = 12;
constexpr double kOwnBlur = 0.3;

// How far the bar's other edge is, towards the edge's normal: the nearer one of its ends.
double bar_width(const ProjectedEdge& edge, const ProjectedEdge& other) {
  const double end[2] = {other.start[0] + other.span[0], other.start[1] + other.span[1]};
  const double first = edge.across(other.start), second = edge.across(end);
  return std::fabs(first) <= std::fabs(second) ? first : second;
}

// Median blur of the agreeing samples of edges first .. last - 1 of all views' edges; *count: how many they are.
double median_blur(const EdgeSamples& samples, int32_t first, int32_t last, double* scratch, int32_t* count) {
  *count = 0;
  for (uint32_t i = samples.begin[first]; i < samples.begin[last]; ++i) {
    if (samples.weights[i] > kTrusted) scratch[(*count)++] = samples.steps[i].blur;
  }
  return *count > 0 ? math::median(scratch, *count) : 0.0;
}

}  // namespace

bool face_widths(const Scene& scene, const math::Transform& T, double* widths) {
  std::fill(widths, widths + scene.size(), 0.0);
  const rvdnav_edge_model& model = scene.model();
  for (int32_t camera = 0; scene.is_bracket() && camera < scene.views; ++camera) {
    const ViewPose view = view_pose(scene.problem->cameras, camera, T);
    ProjectedEdge edges[RVDNAV_EDGES];
    for (int32_t e = 0; e < RVDNAV_EDGES; ++e) {
      if (!project_edge(view, edge_end(model, e, 0), edge_end(model, e, 1), edges + e)) return false;
    }
    for (int32_t e = 0; e < RVDNAV_EDGES; ++e) widths[scene.index(camera, e)] = bar_width(edges[e], edges[e ^ 1]);
  }
  return true;
}

void update_blur(const Scene& scene, const EdgeSamples& samples, double* scratch, double* blur) {
  for (int32_t camera = 0; camera < scene.views; ++camera) {
    const int32_t first = scene.index(camera, 0);
    int32_t count = 0;
    const double of_view = median_blur(samples, first, first + scene.edges, scratch, &count);
    if (count == 0) continue;
    for (int32_t i = first; i < first + scene.edges; ++i) {
      const double own = median_blur(samples, i, i + 1, scratch, &count);
      const bool apart = count >= kMinBlurs && std::fabs(own / of_view - 1.0) > kOwnBlur;
      blur[i] = apart ? own : of_view;
    }
  }
}

double blur_excess(double blur) { return std::sqrt(std::max(blur * blur - kSharp * kSharp, 0.0)); }

void allow_for_slopes(const Scene& scene, EdgeSamples* samples, double* scratch, double* moved) {
  for (int32_t i = 0; i < scene.size(); ++i) {
    const uint32_t begin = samples->begin[i], n = samples->begin[i + 1] - begin;
    moved[i] = 0.0;
    if (n == 0) continue;
    for (uint32_t k = 0; k < n; ++k) scratch[k] = samples->steps[begin + k].slope;
    const double slope = math::median(scratch, static_cast<int32_t>(n)), square = slope * slope;
    const double part = square * square / (square * square + kSlopeSigma * kSlopeSigma * kSlopeSigma * kSlopeSigma);
    for (uint32_t k = 0; k < n; ++k) {
      rvdnav_edge_point& point = samples->points[begin + k];
      const double shift = samples->steps[begin + k].slope_shift;
      scratch[k] = shift;
      point.x += part * shift * point.nx;
      point.y += part * shift * point.ny;
    }
    moved[i] = std::fabs(part * math::median(scratch, static_cast<int32_t>(n)));
  }
}

}  // namespace rvdnav
