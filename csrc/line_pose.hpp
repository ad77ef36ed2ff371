// Pose from lines: least squares over image lines matched to edges of the bracket.
#pragma once

#include <cstdint>

#include <Eigen/Core>

#include "bracket_model.hpp"
#include "line2.hpp"
#include "rect_rig.hpp"

namespace rvdnav {

// An image line taken for an edge of the bracket; the fit pulls the edge's projection onto it at both of its ends.
struct LineMatch {
  int32_t camera;
  int32_t edge;
  int32_t polarity;  // +1: brighter on the side that the normal (-dy, dx) of the edge's projection points to
  Line2 line;
  double weight;
  Eigen::Vector3d from, to;  // the part of the edge that the line was seen on, in C
};

// Levenberg-Marquardt over the signed distances of from and to.  Returns false when the pose leaves the space in front
// of the cameras, the normal equations are singular, or the residual is still above hopeless_rms after a few
// iterations. *rms is the weighted residual in pixels.
bool fit_pose_to_lines(const RectRig& rig, const LineMatch* matches, uint32_t count, int32_t max_iterations,
                       double hopeless_rms, Pose* pose, double* rms);

// The same with the right view's shift, which a calibration that is off makes seem to lie elsewhere: it is found with the
// pose, as normally distributed about zero with a standard deviation of shift_sigma pixels.
bool fit_pose_and_shift(RectRig* rig, const LineMatch* matches, uint32_t count, double shift_sigma,
                        int32_t max_iterations, double hopeless_rms, Pose* pose, double* rms);

}  // namespace rvdnav
