// A target's pose as one camera sees it.
#pragma once

#include <stdint.h>

#include "math/so3.hpp"
#include "rvdnav/rvdnav.h"

namespace rvdnav {

// Maps C to the rectified axes, from the camera's centre.
struct ViewPose {
  double R[9];
  double p[3];
  double focal;  // pixels

  void place(const double* point_C, double* point) const {
    math::multiply_3(R, point_C, point);
    for (int32_t i = 0; i < 3; ++i) point[i] += p[i];
  }
};

ViewPose view_pose(const rvdnav_pose_cameras& cameras, int32_t camera, const math::Transform& T);

// Where a camera's centre lies in C, metres.
void eye_in_target(const rvdnav_pose_cameras& cameras, int32_t camera, const math::Transform& T, double* eye);

// An edge in a rectified view, pixels from the principal point.
struct ProjectedEdge {
  double start[2], span[2];
  double normal[2];  // unit, (-dy, dx); 0 for one that is seen end-on

  double across(const double* xy) const { return normal[0] * (xy[0] - start[0]) + normal[1] * (xy[1] - start[1]); }
};

// False for an end that is not in front of the camera.
bool project_edge(const ViewPose& view, const double* from_C, const double* to_C, ProjectedEdge* edge);

}  // namespace rvdnav
