// Sub-pixel lines: a tracked peak's line fitted again to the grey values along it.
#pragma once

#include "profile.hpp"

namespace rvdnav {

// Refits a found line over [t_min, t_max] in place; it stays as it was, with refitted = 0, where too few profiles
// agree.
void refit_line(const rvdnav_rig& rig, int32_t camera, const GreyView& image, double blur_sigma, rvdnav_line* line);

}  // namespace rvdnav
