// The rectified stereo pair as the geometry stages see it.
//
// Frame R: the axes of the rectified cameras (x right, y down, z forward), origin in the right camera's centre; with
// one camera, in that camera's centre.  W and R share the origin: x_R = -z_W, y_R = y_W, z_R = x_W.
#pragma once

#include <Eigen/Core>

#include "rvdnav/rvdnav.h"

namespace rvdnav {

struct RectRig {
  double focal;     // pixels
  double baseline;  // metres, from the right to the left camera along -x_R
  Eigen::Vector2d right_shift = Eigen::Vector2d::Zero();  // pixels, by which the right view lies off its calibration

  // The camera's centre in R.
  Eigen::Vector3d centre(int32_t camera) const { return {camera == 0 ? -baseline : 0.0, 0.0, 0.0}; }

  // Rectified pixel of a point in front of the camera.
  Eigen::Vector2d project(int32_t camera, const Eigen::Vector3d& p_R) const {
    const Eigen::Vector3d p = p_R - centre(camera);
    const Eigen::Vector2d xy(focal * p.x() / p.z(), focal * p.y() / p.z());
    return camera == 0 ? xy : Eigen::Vector2d(xy + right_shift);
  }
};

inline RectRig rect_rig(const rvdnav_rig& rig) {
  RectRig rect;
  rect.focal = rig.focal_rect;
  rect.baseline = rig.baseline;
  return rect;
}

inline Eigen::Matrix3d R_world_rect() {
  Eigen::Matrix3d R;
  R << 0, 0, 1,  //
      0, 1, 0,   //
      -1, 0, 0;
  return R;
}

// Maps coordinates in C to coordinates in R.
struct Pose {
  Eigen::Matrix3d R;
  Eigen::Vector3d p;

  Eigen::Vector3d operator*(const Eigen::Vector3d& p_C) const { return R * p_C + p; }
};

}  // namespace rvdnav
