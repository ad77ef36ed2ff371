#include "pose/view_pose.hpp"

#include <algorithm>
#include <cmath>

namespace rvdnav {
namespace {

constexpr double kLeastLength = 1e-9;  // pixels

bool project(const ViewPose& view, const double* point_C, double* xy) {
  double point[3];
  view.place(point_C, point);
  if (!(point[2] > 0.0)) return false;
  const double scale = view.focal / point[2];
  xy[0] = scale * point[0];
  xy[1] = scale * point[1];
  return true;
}

}  // namespace

ViewPose view_pose(const rvdnav_pose_cameras& cameras, int32_t camera, const math::Transform& T) {
  ViewPose view;
  math::multiply_3x3(cameras.R_rect_W, T.R, view.R);
  double from_eye[3];
  for (int32_t i = 0; i < 3; ++i) from_eye[i] = T.p[i] - cameras.centre[camera][i];
  math::multiply_3(cameras.R_rect_W, from_eye, view.p);
  view.focal = cameras.focal;
  return view;
}

void eye_in_target(const rvdnav_pose_cameras& cameras, int32_t camera, const math::Transform& T, double* eye) {
  double from_target[3];
  for (int32_t i = 0; i < 3; ++i) from_target[i] = cameras.centre[camera][i] - T.p[i];
  math::multiply_transposed_3(T.R, from_target, eye);
}

bool project_edge(const ViewPose& view, const double* from_C, const double* to_C, ProjectedEdge* edge) {
  double end[2];
  if (!project(view, from_C, edge->start) || !project(view, to_C, end)) return false;
  for (int32_t i = 0; i < 2; ++i) edge->span[i] = end[i] - edge->start[i];
  const double square = edge->span[0] * edge->span[0] + edge->span[1] * edge->span[1];
  const double length = std::max(std::sqrt(square), kLeastLength);
  edge->normal[0] = -edge->span[1] / length;
  edge->normal[1] = edge->span[0] / length;
  return true;
}

}  // namespace rvdnav
