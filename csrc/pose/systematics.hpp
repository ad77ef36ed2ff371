// What is known of parameters beside the pose before a frame: each has unit standard deviation as stated, times its
// group's scale, and earlier frames told more.
#pragma once

#include <stdint.h>

#include "rvdnav/rvdnav.h"

namespace rvdnav {

// U (p, p), with U^T U the information of all that is known, and the mean (p) expected by it.  False if the information
// of earlier frames is not positive semidefinite.
bool prior_of(const rvdnav_pose_problem& problem, const double* scales, double* U, double* mean);

// The scales at which the groups' squares are those of their well-determined parameters (D. J. C. MacKay, "Bayesian
// interpolation", 1992), of an estimate z (p) with variances (p) at the present scales.
void rescale(const rvdnav_pose_problem& problem, const double* z, const double* variances, double* scales);

}  // namespace rvdnav
