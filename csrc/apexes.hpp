// The bracket's apexes in one view, as intersections of its lines.
#pragma once

#include "bracket_model.hpp"
#include "rvdnav/rvdnav.h"

namespace rvdnav {

// P1..P4 from the outer and Q1..Q4 from the inner lines.  Returns the mask of those whose two lines were found.
uint32_t intersect_lines(const rvdnav_line lines[RVDNAV_EDGES], double apexes[RVDNAV_APEXES][2]);

}  // namespace rvdnav
