// What speaks for a refined pose: which edges the views show where it puts them.
#pragma once

#include "navigator/measured_lines.hpp"

namespace rvdnav {

// Evidence (views, edges) of the samples and lines at a pose that was refined over them with these weights (n);
// half_width: of the profiles, pixels; blur (views, edges).  A status as of sample_target.
rvdnav_status gather_evidence(const Scene& scene, const math::Transform& T, const MeasuredLines& lines,
                              const double* weights, double half_width, const double* blur, MeasuringMemory* memory,
                              rvdnav_edge_evidence* evidence);

}  // namespace rvdnav
