// Stage 7 for the edges of a target: where a pose puts them in the views, and their steps there.
#pragma once

#include "profile.hpp"
#include "rvdnav/rvdnav.h"

namespace rvdnav {

constexpr int32_t kMostProfiles = 80;  // across an edge

// Places the edges in the views and measures them there: the profiles of a view stand a pixel apart, or farther, so
// that its longest edge has kMostProfiles.  images: of each camera.  samples: kMostProfiles for each edge.  Returns the
// number of samples written.
uint32_t sample_edges(const rvdnav_rig& rig, const GreyView* images, const rvdnav_seen_edge* edges, uint32_t edge_count,
                      double shortest, ProfileSettings settings, rvdnav_edge_sample* samples,
                      rvdnav_edge_coverage* coverage);

}  // namespace rvdnav
