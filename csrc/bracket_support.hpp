// How well segments of an image support a pose of the bracket.
#pragma once

#include <cstdint>

#include "bracket_model.hpp"
#include "line_pose.hpp"
#include "rect_rig.hpp"

namespace rvdnav {

// The segments that one view offers.
struct ViewSegments {
  const rvdnav_segment* segments;
  const Line2* lines;  // of the segments
  uint32_t count;
};

struct Tolerance {
  double distance;  // pixels across an edge
  double angle;     // sine of the angle between the directions
};

// For each of the bracket's edges the segment that lies best on its projection, or on that of the back edge of its side
// face where this is in sight, as input to the pose fit.  Returns the
// number of matches, at most RVDNAV_EDGES.
uint32_t match_edges(const RectRig& rig, const BracketModel& model, int32_t camera, const ViewSegments& view,
                     const Pose& pose, const Tolerance& tolerance, LineMatch* matches);

// Part of each edge's projected length that is covered by segments within the tolerance, 0..1, counted less the farther
// they lie off; apart for the two polarities: [0] darker, [1] brighter on the side that (-dy, dx) of the edge points
// to.
struct EdgeSupport {
  double covered[RVDNAV_EDGES][2];
  double length[RVDNAV_EDGES];  // pixels
};

EdgeSupport edge_support(const RectRig& rig, const BracketModel& model, int32_t camera, const ViewSegments& view,
                         const Pose& pose, const Tolerance& tolerance);

// What views agree on: an edge has the same bright side in all of them.
struct CombinedSupport {
  double fraction;               // of the edges' length over all views
  double covered[RVDNAV_EDGES];  // of each edge, mean over the views
};

CombinedSupport combine(const EdgeSupport* views, int32_t view_count);

}  // namespace rvdnav
