// Both cameras' parts of a frame brought together.
#pragma once

#include "context.hpp"

namespace rvdnav {

// Bracket (when acquiring, from what process_view left in the workspaces), lines, apexes, correlation, triangulation.
// A camera without image has a null image and a null result.
rvdnav_status join_views(Context& context, const GreyView* left, const GreyView* right,
                         const rvdnav_view_result* left_view, const rvdnav_view_result* right_view, bool acquire,
                         rvdnav_frame_result* result);

}  // namespace rvdnav
