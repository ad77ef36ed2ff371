// Where a pose lets the bracket's edges be expected in Hough space.
#pragma once

#include "bracket_model.hpp"
#include "rect_rig.hpp"

namespace rvdnav {

// Fills one window an edge, with the given half-widths (pixels, radians).  Returns the number written: edges that reach
// behind the camera are left out.
uint32_t expect_edges(const RectRig& rig, const BracketModel& model, int32_t camera, const Pose& pose, double half_rho,
                      double half_theta, rvdnav_window windows[RVDNAV_EDGES]);

}  // namespace rvdnav
