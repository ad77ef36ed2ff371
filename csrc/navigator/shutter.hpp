// A rolling shutter: the rows of an image show the target at different times, the stamp is of the first row.
//
// Between the stamp and a row's exposure the target goes on as the filter has it, and its edges with it; where they are
// measured is referred to the stamp, and what is not known of the motion is estimated with the pose.
#pragma once

#include "navigator/edge_samples.hpp"

namespace rvdnav {

// Adds to offsets (views, edges, 2), pixels, how far the ends of the edges are seen from where they were at the stamp,
// towards the normal (-dy, dx).  False for a target that is not in front of the cameras.
bool add_shutter_offsets(const Scene& scene, const math::Transform& T, double* offsets);

// Moves the points to where their steps were at the stamp, near a pose.  False as above.
bool refer_to_stamp(const Scene& scene, const math::Transform& T, EdgeSamples* samples);

// Derivatives of n lines' residuals with respect to the velocity, in its standard deviations: the first of six columns
// of rows (2 n) that are stride apart.  False for an edge that is not in front of its camera or a covariance that is
// none.
bool motion_derivatives(const Scene& scene, const math::Transform& T, const rvdnav_pose_line* lines, int32_t n,
                        double* derivative, ptrdiff_t stride);

}  // namespace rvdnav
