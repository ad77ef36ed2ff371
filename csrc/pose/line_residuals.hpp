// Distances of the projected ends of edges to their measured lines, and what is known of the distances' errors.
#pragma once

#include <stdint.h>

#include "math/so3.hpp"
#include "rvdnav/rvdnav.h"

namespace rvdnav {

// A measured line and the part of an edge that it was seen on; what of it doesn't depend on the pose.
struct DirectedLine {
  double ends[2][3];  // in the target's frame, metres
  double nx, ny;      // the line's normal
  double rho;         // pixels
  double centre[3];   // of its camera, in rectified axes, metres
};

DirectedLine directed_line(const rvdnav_pose_cameras& cameras, const rvdnav_pose_line& line);

// Distances r (n, 2), pixels, and their derivatives J (n, 2, 6) with respect to (dp, dtheta) of p + dp and
// exp([dtheta]x) R.  False if an end is not in front of its camera.
bool line_residuals(const rvdnav_pose_cameras& cameras, const DirectedLine* lines, int32_t n, const math::Transform& T,
                    double* r, double* J);

// Of a line's offset, the mean of its ends' distances, and its tilt, half of their difference.
struct OffsetTilt {
  double offset, mixed, tilt;
};

// Variances and covariance (n), px^2, as far as the lines' own covariances and shift_sigma tell.  False if an end is
// not in front of its camera.
bool known_variances(const rvdnav_pose_cameras& cameras, const rvdnav_pose_line* stated, const DirectedLine* lines,
                     int32_t n, const math::Transform& T, OffsetTilt* known);

}  // namespace rvdnav
