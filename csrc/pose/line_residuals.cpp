#include "pose/line_residuals.hpp"

#include "math/elementary.hpp"

namespace rvdnav {
namespace {

// The target's pose as the rectified cameras see it.
struct RectifiedPose {
  double R[9];
  double p[3];
};

RectifiedPose rectified_pose(const rvdnav_pose_cameras& cameras, const math::Transform& T) {
  RectifiedPose pose;
  math::multiply_3x3(cameras.R_rect_W, T.R, pose.R);
  math::multiply_3(cameras.R_rect_W, T.p, pose.p);
  return pose;
}

// A point's place by the target's origin and by its camera, both in rectified axes.  False if it is behind the camera.
bool place(const RectifiedPose& pose, const DirectedLine& line, int32_t end, double* arm, double* point) {
  math::multiply_3(pose.R, line.ends[end], arm);
  for (int32_t i = 0; i < 3; ++i) point[i] = arm[i] + (pose.p[i] - line.centre[i]);
  return point[2] > 0.0;
}

}  // namespace

DirectedLine directed_line(const rvdnav_pose_cameras& cameras, const rvdnav_pose_line& line) {
  DirectedLine directed;
  for (int32_t i = 0; i < 3; ++i) {
    directed.ends[0][i] = line.from_C[i];
    directed.ends[1][i] = line.to_C[i];
  }
  directed.nx = math::cos(line.theta);
  directed.ny = math::sin(line.theta);
  directed.rho = line.rho;
  math::multiply_3(cameras.R_rect_W, cameras.centre[line.camera], directed.centre);
  return directed;
}

bool line_residuals(const rvdnav_pose_cameras& cameras, const DirectedLine* lines, int32_t n, const math::Transform& T,
                    double* r, double* J) {
  const RectifiedPose pose = rectified_pose(cameras, T);
  for (int32_t i = 0; i < n; ++i) {
    const DirectedLine& line = lines[i];
    for (int32_t end = 0; end < 2; ++end, ++r, J += 6) {
      double arm[3], point[3];
      if (!place(pose, line, end, arm, point)) return false;
      const double inverse_depth = 1.0 / point[2];
      const double scale = cameras.focal * inverse_depth;
      const double g0 = line.nx * scale, g1 = line.ny * scale;
      const double along = g0 * point[0] + g1 * point[1];
      const double gradient[3] = {g0, g1, -along * inverse_depth};
      // A turn dtheta moves the point by dtheta x arm, and g . (dtheta x arm) = dtheta . (arm x g).
      const double turn[3] = {arm[1] * gradient[2] - arm[2] * g1, arm[2] * g0 - arm[0] * gradient[2],
                              arm[0] * g1 - arm[1] * g0};
      *r = along - line.rho;
      math::multiply_transposed_3(cameras.R_rect_W, gradient, J);
      math::multiply_transposed_3(cameras.R_rect_W, turn, J + 3);
    }
  }
  return true;
}

bool known_variances(const rvdnav_pose_cameras& cameras, const rvdnav_pose_line* stated, const DirectedLine* lines,
                     int32_t n, const math::Transform& T, OffsetTilt* known) {
  const RectifiedPose pose = rectified_pose(cameras, T);
  for (int32_t i = 0; i < n; ++i) {
    double along[2];
    for (int32_t end = 0; end < 2; ++end) {
      double arm[3], point[3];
      if (!place(pose, lines[i], end, arm, point)) return false;
      along[end] = cameras.focal * (point[1] * lines[i].nx - point[0] * lines[i].ny) / point[2];
    }
    // distance = x cos(theta) + y sin(theta) - rho: its derivatives are -1 by rho and `along` by theta.
    const double middle = 0.5 * (along[0] + along[1]), half = 0.5 * (along[1] - along[0]);
    const double* cov = stated[i].covariance;
    const double shift = stated[i].shift_sigma;
    known[i].offset = cov[0] - 2.0 * middle * cov[1] + middle * middle * cov[3] + shift * shift;
    known[i].mixed = half * (middle * cov[3] - cov[1]);
    known[i].tilt = half * half * cov[3];
  }
  return true;
}

}  // namespace rvdnav
