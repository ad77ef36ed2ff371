// How the calibration's errors show in measured lines.
#pragma once

#include <stddef.h>

#include "rvdnav/rvdnav.h"

namespace rvdnav {

constexpr int32_t kEffectDegree = 11;  // of the shifts' polynomials, along and down the image

// Derivatives (parameters) of the distances of an edge's two projected ends from a measured line, in two rows that are
// stride apart.  The line moves with the straight line through the shifted points that it was measured at: those of its
// edge that lie on the image.  The ends are in front of the camera.
void calibration_derivatives(const rvdnav_rig& rig, const rvdnav_calibration_effect& effect,
                             const rvdnav_measured_line& line, double* derivatives, ptrdiff_t stride);

}  // namespace rvdnav
