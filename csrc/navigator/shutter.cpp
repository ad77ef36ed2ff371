#include "navigator/shutter.hpp"

#include <algorithm>
#include <cmath>

#include "lens.hpp"
#include "math/matrix.hpp"
#include "pose/line_residuals.hpp"
#include "pose/view_pose.hpp"

namespace rvdnav {
namespace {

// For how long the target is moved on to tell how fast its edges move.
constexpr double kStep = 1e-3;  // s

// The exposure of a rectified point's row after the stamp, s.
double delay(const Scene& scene, int32_t camera, const double* xy) {
  double u = 0.0, v = 0.0;
  rect_to_raw(*scene.rig, camera, xy[0], xy[1], &u, &v);
  const double row = std::isnan(v) ? 0.0 : std::clamp(v, 0.0, scene.rig->height - 1.0);
  return scene.problem->motion.row_seconds * row;
}

// An edge at the stamp, and how fast its ends move across it, pixels/s.
struct MovingEdge {
  ProjectedEdge edge;
  double rate[2];
};

// How a view sees the target at the stamp and a step later.
struct MovingView {
  ViewPose now, later;
};

MovingView moving_view(const Scene& scene, int32_t camera, const math::Transform& T) {
  double step[6];
  for (int32_t i = 0; i < 6; ++i) step[i] = kStep * scene.problem->motion.velocity[i];
  return {view_pose(scene.problem->cameras, camera, T),
          view_pose(scene.problem->cameras, camera, math::perturb(T, step))};
}

bool moving_edge(const MovingView& view, const rvdnav_edge_model& model, int32_t edge, MovingEdge* moving) {
  const double *from = edge_end(model, edge, 0), *to = edge_end(model, edge, 1);
  ProjectedEdge later;
  if (!project_edge(view.now, from, to, &moving->edge) || !project_edge(view.later, from, to, &later)) return false;
  const ProjectedEdge& now = moving->edge;
  for (int32_t end = 0; end < 2; ++end) {
    const double dx = later.start[0] - now.start[0] + end * (later.span[0] - now.span[0]);
    const double dy = later.start[1] - now.start[1] + end * (later.span[1] - now.span[1]);
    moving->rate[end] = (now.normal[0] * dx + now.normal[1] * dy) / kStep;
  }
  return true;
}

}  // namespace

bool add_shutter_offsets(const Scene& scene, const math::Transform& T, double* offsets) {
  for (int32_t camera = 0; camera < scene.views; ++camera) {
    const MovingView view = moving_view(scene, camera, T);
    for (int32_t e = 0; e < scene.edges; ++e) {
      MovingEdge moving;
      if (!moving_edge(view, scene.model(), e, &moving)) return false;
      const ProjectedEdge& edge = moving.edge;
      for (int32_t end = 0; end < 2; ++end) {
        const double xy[2] = {edge.start[0] + end * edge.span[0], edge.start[1] + end * edge.span[1]};
        offsets[2 * scene.index(camera, e) + end] += moving.rate[end] * delay(scene, camera, xy);
      }
    }
  }
  return true;
}

bool refer_to_stamp(const Scene& scene, const math::Transform& T, EdgeSamples* samples) {
  for (int32_t camera = 0; camera < scene.views; ++camera) {
    const MovingView view = moving_view(scene, camera, T);
    for (int32_t e = 0; e < scene.edges; ++e) {
      const int32_t index = scene.index(camera, e);
      MovingEdge moving;
      if (samples->begin[index] == samples->begin[index + 1]) continue;
      if (!moving_edge(view, scene.model(), e, &moving)) return false;
      const ProjectedEdge& edge = moving.edge;
      const double square = edge.span[0] * edge.span[0] + edge.span[1] * edge.span[1];
      for (uint32_t i = samples->begin[index]; i < samples->begin[index + 1]; ++i) {
        rvdnav_edge_point& point = samples->points[i];
        const double xy[2] = {point.x, point.y};
        const double part = ((xy[0] - edge.start[0]) * edge.span[0] + (xy[1] - edge.start[1]) * edge.span[1]) / square;
        const double speed = moving.rate[0] + part * (moving.rate[1] - moving.rate[0]);
        const double shift = speed * delay(scene, camera, xy);
        point.x -= shift * point.nx;
        point.y -= shift * point.ny;
      }
    }
  }
  return true;
}

bool motion_derivatives(const Scene& scene, const math::Transform& T, const rvdnav_pose_line* lines, int32_t n,
                        double* derivative, ptrdiff_t stride) {
  const rvdnav_pose_cameras& cameras = scene.problem->cameras;
  double U[36];  // of the covariance U^T U
  std::copy(scene.problem->motion.covariance, scene.problem->motion.covariance + 36, U);
  if (!math::cholesky(U, 6)) return false;
  for (int32_t i = 0; i < n; ++i) {
    const DirectedLine line = directed_line(cameras, lines[i]);
    const ViewPose view = view_pose(cameras, lines[i].camera, T);
    double r[2], J[12];
    ProjectedEdge edge;
    if (!line_residuals(cameras, &line, 1, T, r, J)) return false;
    if (!project_edge(view, lines[i].from_C, lines[i].to_C, &edge)) return false;
    for (int32_t end = 0; end < 2; ++end) {
      const double xy[2] = {edge.start[0] + end * edge.span[0], edge.start[1] + end * edge.span[1]};
      const double seconds = delay(scene, lines[i].camera, xy);
      double* out = derivative + (2 * i + end) * stride;
      for (int32_t j = 0; j < 6; ++j) out[j] = seconds * math::dot(U + 7 * j, J + 6 * end + j, 6 - j);
    }
  }
  return true;
}

}  // namespace rvdnav
