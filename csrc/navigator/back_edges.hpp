// The far edges of side faces as evidence: a bar whose side face is lit like its front ends there.
//
// They say that the bar is where the pose puts it, but take no part in the refinement.
#pragma once

#include "navigator/measured_lines.hpp"

namespace rvdnav {

// Sets the back coverage of a bracket's edges that agree less than all along, where the side face is in sight and wide
// enough to tell its back edge from the front one.  A status as of sample_target.
rvdnav_status add_back_edges(const Scene& scene, const math::Transform& T, MeasuringMemory* memory,
                             rvdnav_edge_evidence* evidence);

}  // namespace rvdnav
