#include "navigator/systematics.hpp"

#include <algorithm>
#include <cmath>
#include <limits>

#include "calibration_effect.hpp"
#include "math/elementary.hpp"
#include "math/matrix.hpp"
#include "navigator/shutter.hpp"
#include "navigator/surroundings.hpp"
#include "pose/view_pose.hpp"
#include "target/edge_model.hpp"

namespace rvdnav {
namespace {

constexpr int32_t kGroups = 5;
// How many independent errors the stated standard deviations are worth against those that the lines show: a maker who
// says 0.3 mm may mean 0.1 or 1; of a calibration fewer parameters show in the images; what the filter says stands.
constexpr double kWeights[kGroups] = {1.0, 4.0, 1.0, 1.0, std::numeric_limits<double>::infinity()};
// The largest scales: how far what was said can be from what is, before the frame is not to be believed.
constexpr double kLargest[kGroups] = {5.0, 5.0, 20.0, 25.0, 1.0};
constexpr int32_t kDoubtful[kGroups] = {1, 1, 0, 0, 0};
// By how much a step is displaced towards its dark side, as a part of its blur: sharpening, a response that bends.
constexpr double kStepPart = 0.015;
// By how much an edge is displaced in all views alike by what lies beside it: of a sharp image, pixels, and as a part
// of the blur beyond that.
constexpr double kEdgeSigma = 0.007;
constexpr double kEdgePart = 0.06;

// Derivatives (2, 3) of a line's two distances with respect to the places of its own ends in C, pixels/m.
void by_ends(const ViewPose& view, const rvdnav_measured_line& line, double (&derivative)[2][3]) {
  const double nx = math::cos(line.theta), ny = math::sin(line.theta);
  for (int32_t end = 0; end < 2; ++end) {
    const double* p = line.ends[end];
    const double scale = view.focal / p[2];
    const double gradient[3] = {scale * nx, scale * ny, -scale * (nx * p[0] + ny * p[1]) / p[2]};
    math::multiply_transposed_3(view.R, gradient, derivative[end]);
  }
}

// The columns of the points that are not exact, of the two rows of a line; part: where on the edge its ends lie.
void fill_by_points(const rvdnav_edge_model& model, int32_t edge, const double (&by_end)[2][3], const double* part,
                    double* first, ptrdiff_t stride) {
  ptrdiff_t column = 0;
  for (int32_t point = 0; point < static_cast<int32_t>(model.point_count); ++point) {
    const double sigma = model.point_sigmas[point];
    if (!(sigma > 0.0)) continue;
    for (int32_t end = 0; end < 2; ++end) {
      double share = point == model.ends[2 * edge] ? 1.0 - part[end] : 0.0;
      if (point == model.ends[2 * edge + 1]) share += part[end];
      double* out = first + end * stride + column;
      for (int32_t i = 0; i < 3; ++i) out[i] = sigma * share * by_end[end][i];
    }
    column += 3;
  }
}

// The columns of the lasting parameters, of the two rows of a line that are stride apart; ends in C.  False for one
// that is not in front of the camera.
bool fill_lasting(const Scene& scene, const ViewPose& view, int32_t edge, const double* from_C, const double* to_C,
                  rvdnav_measured_line* line, double* rows, ptrdiff_t stride) {
  const rvdnav_edge_model& model = scene.model();
  view.place(from_C, line->ends[0]);
  view.place(to_C, line->ends[1]);
  if (!(line->ends[0][2] > 0.0 && line->ends[1][2] > 0.0)) return false;
  const ParameterCounts counts = parameter_counts(*scene.problem, scene.views);
  if (counts.points > 0) {
    double by_end[2][3];
    by_ends(view, *line, by_end);
    const double part[2] = {part_along(model, edge, from_C), part_along(model, edge, to_C)};
    fill_by_points(model, edge, by_end, part, rows, stride);
  }
  if (counts.calibration > 0) {
    calibration_derivatives(*scene.rig, *scene.problem->effect, *line, rows + counts.points, stride);
  }
  return true;
}

// The edge's own line, from one end to the other.
bool line_of_edge(const ViewPose& view, const rvdnav_edge_model& model, int32_t edge, rvdnav_measured_line* line) {
  ProjectedEdge projected;
  if (!project_edge(view, edge_end(model, edge, 0), edge_end(model, edge, 1), &projected)) return false;
  line->theta = math::atan2(projected.span[0], -projected.span[1]);
  line->rho = math::cos(line->theta) * projected.start[0] + math::sin(line->theta) * projected.start[1];
  return true;
}

}  // namespace

ParameterCounts parameter_counts(const rvdnav_measurement_problem& problem, int32_t views) {
  const rvdnav_edge_model& model = *problem.model;
  ParameterCounts counts = {0, 0, views, static_cast<int32_t>(model.edge_count), 0};
  for (uint32_t i = 0; i < model.point_count; ++i) counts.points += model.point_sigmas[i] > 0.0 ? 3 : 0;
  if (problem.effect != nullptr) counts.calibration = static_cast<int32_t>(problem.effect->parameters);
  if (problem.motion.row_seconds > 0.0) counts.motion = 6;
  return counts;
}

void lay_out(const ParameterCounts& counts, int32_t lines, Arena& arena, SystematicsMemory* memory) {
  const size_t p = static_cast<size_t>(counts.all());
  arena.take(&memory->derivative, 2 * static_cast<size_t>(lines) * p);
  arena.take(&memory->information, p * p);
  arena.take(&memory->vector, p);
  arena.take(&memory->row, 2 * static_cast<size_t>(counts.lasting()));
}

bool lasting_offsets(const Scene& scene, const math::Transform& T, const double* z, const SystematicsMemory& memory,
                     double* offsets) {
  const int32_t q = parameter_counts(*scene.problem, scene.views).lasting();
  std::fill(offsets, offsets + 2 * scene.size(), 0.0);
  if (std::all_of(z, z + q, [](double value) { return value == 0.0; })) return true;
  const rvdnav_edge_model& model = scene.model();
  for (int32_t camera = 0; camera < scene.views; ++camera) {
    const ViewPose view = view_pose(scene.problem->cameras, camera, T);
    for (int32_t e = 0; e < scene.edges; ++e) {
      rvdnav_measured_line line = {};
      line.camera = camera;
      if (!line_of_edge(view, model, e, &line)) return false;
      if (!fill_lasting(scene, view, e, edge_end(model, e, 0), edge_end(model, e, 1), &line, memory.row, q))
        return false;
      double* offset = offsets + 2 * scene.index(camera, e);
      for (int32_t end = 0; end < 2; ++end) offset[end] = math::dot(memory.row + end * q, z, q);
    }
  }
  return true;
}

bool set_systematics(const Scene& scene, const math::Transform& T, const LineCircumstances& circumstances,
                     const SystematicsMemory& memory, rvdnav_pose_problem* problem) {
  const rvdnav_measurement_problem& known = *scene.problem;
  const ParameterCounts counts = parameter_counts(known, scene.views);
  const int32_t p = counts.all(), q = counts.lasting(), n = static_cast<int32_t>(problem->line_count);
  ViewPose views[RVDNAV_CAMERAS];
  for (int32_t camera = 0; camera < scene.views; ++camera) views[camera] = view_pose(known.cameras, camera, T);
  std::fill(memory.derivative, memory.derivative + static_cast<ptrdiff_t>(2) * n * p, 0.0);
  for (int32_t i = 0; i < n; ++i) {
    const rvdnav_pose_line& line = problem->lines[i];
    rvdnav_measured_line measured = {line.rho, line.theta, {}, line.camera, 0};
    double* rows = memory.derivative + static_cast<ptrdiff_t>(2) * i * p;
    const int32_t edge = circumstances.edge[i];
    if (!fill_lasting(scene, views[line.camera], edge, line.from_C, line.to_C, &measured, rows, p)) return false;
    const double blurred = kEdgePart * blur_excess(circumstances.blur[i]);
    for (int32_t end = 0; end < 2; ++end) {
      double* own = rows + end * p + q;
      own[line.camera] = -(kStepPart * circumstances.blur[i] * circumstances.polarity[i]);
      own[counts.views + edge] = -std::sqrt(kEdgeSigma * kEdgeSigma + blurred * blurred);
    }
  }
  if (counts.motion > 0 && !motion_derivatives(scene, T, problem->lines, n, memory.derivative + p - 6, p)) return false;
  std::fill(memory.information, memory.information + static_cast<ptrdiff_t>(p) * p, 0.0);
  std::fill(memory.vector, memory.vector + p, 0.0);
  for (int32_t i = 0; i < q; ++i) {
    std::copy(known.information + static_cast<ptrdiff_t>(i) * q, known.information + static_cast<ptrdiff_t>(i + 1) * q,
              memory.information + static_cast<ptrdiff_t>(i) * p);
  }
  std::copy(known.vector, known.vector + q, memory.vector);
  const int32_t sizes[kGroups] = {counts.points, counts.calibration, counts.views, counts.edges, counts.motion};
  for (int32_t g = 0; g < kGroups; ++g) {
    problem->groups[g] = {static_cast<uint32_t>(sizes[g]), kDoubtful[g], known.scales[g], kWeights[g], kLargest[g]};
  }
  problem->group_count = kGroups;
  problem->parameter_count = static_cast<uint32_t>(p);
  problem->derivative = memory.derivative;
  problem->information = memory.information;
  problem->vector = memory.vector;
  return true;
}

}  // namespace rvdnav
