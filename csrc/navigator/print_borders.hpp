// Steps beside an edge that may be the edge instead: a print's border within a few pixels of it.
//
// Between two steps of the same polarity, or before one of the other, the grey values must step back.  Where they do so
// all along an edge and within reach of its profiles, the wrong step may have been measured.
#pragma once

#include "navigator/measured_lines.hpp"

namespace rvdnav {

// Widens the separation of each line's edge to the distance of a line of opposite polarity next to it, pixels.  A
// status as of sample_target.
rvdnav_status widen_to_borders(const Scene& scene, const math::Transform& T, const MeasuredLines& lines,
                               MeasuringMemory* memory);

}  // namespace rvdnav
