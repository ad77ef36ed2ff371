// The lens exactly: raw pixels to rectified pixels and back, in doubles.
#pragma once

#include "rvdnav/rvdnav.h"

namespace rvdnav {

// Where a rectified point (pixels from the principal point) is seen in the raw image; NaN where it is not: behind the
// camera, or so far aside that the distortion has folded back.
void rect_to_raw(const rvdnav_rig& rig, int camera, double x, double y, double* u, double* v);

// The rectified point of a raw pixel, by Newton's method on the distortion.  False if there is none: the distortion
// folds over there or the ray is not in front of the rectified view.
bool raw_to_rect(const rvdnav_rig& rig, int camera, double u, double v, double* x, double* y);

}  // namespace rvdnav
