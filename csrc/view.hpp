// One camera's part of a frame.
#pragma once

#include "bars.hpp"
#include "context.hpp"

namespace rvdnav {

// What can be the width of one of the bracket's bars within the range gate.
BarLimits bar_limits(const Context& context);

// Every stage up to the lines.  Without windows: segments, bars and proposals stay in the camera's workspace for
// join_views.  With windows: tracked and refitted lines.
rvdnav_status process_view(Context& context, int32_t camera, const GreyView& image, const rvdnav_window* windows,
                           uint32_t window_count, rvdnav_view_result* result);

// The peaks in the windows among the edgels of the camera's workspace, refitted to the grey values; fills lines, apexes
// and their masks.
void track_lines(Context& context, int32_t camera, const GreyView& image, const rvdnav_window* windows,
                 uint32_t window_count, rvdnav_view_result* result);

}  // namespace rvdnav
