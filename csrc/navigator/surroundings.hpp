// What lies beside the target's edges in the views: the faces that they bound, blur, slopes of the grey values.
#pragma once

#include "navigator/edge_samples.hpp"

namespace rvdnav {

// Of a bracket's front edges the widths (views, edges), pixels, of their bars, positive where the bar lies towards the
// normal (-dy, dx); 0 for any other target's.  False for a target that is not in front of the cameras.
bool face_widths(const Scene& scene, const math::Transform& T, double* widths);

// Blur (views, edges), pixels, that the samples show which agree with their lines: of an edge the median of its own
// where that is clearly another than its view's, for motion blurs along itself alone; else the median of its view;
// where there are none it stays as it is.  scratch: of the samples.
void update_blur(const Scene& scene, const EdgeSamples& samples, double* scratch, double* blur);

// What of a blur, pixels, goes beyond that of a lens in focus.
double blur_excess(double blur);

// Moves the points to where their steps stand once the slopes beside them are allowed for, as far as an edge shows any:
// a slope that a single profile shows may be noise, and a small one the remains of the blur's model; one that is seen
// all along an edge is there.  moved (views, edges): by how much each edge, in the middle, pixels.
void allow_for_slopes(const Scene& scene, EdgeSamples* samples, double* scratch, double* moved);

}  // namespace rvdnav
