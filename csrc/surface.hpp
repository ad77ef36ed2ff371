// The visible surface: matched zero crossings of a stereo frame, in space.
#pragma once

#include "arena.hpp"
#include "crossing_match.hpp"
#include "rvdnav/rvdnav.h"
#include "types.hpp"

namespace rvdnav {

// Work memory of one view.
struct SurfaceView {
  RectMap map;
  RowSpan* spans;  // height
  PyramidLevel level[kPyramidLevels];
  CrossingRows rows;
};

struct SurfaceMemory {
  SurfaceView view[RVDNAV_CAMERAS];
  int32_t* raw_u;           // width
  int32_t* raw_v;           // width
  uint16_t* filter_row;     // width + 4
  uint16_t* filter_plane;   // width * height
  DisparityTiles tiles[2];  // of a level and of the next finer one
  CrossingScratch match;
  CrossingMatch* matches;
};

// Gives every array its place; with an arena that only counts, the need is what it has used.
void lay_out(const rvdnav_rig& rig, Arena& arena, SurfaceMemory* memory);

struct SurfaceCounts {
  uint32_t written;    // at most the capacity
  uint32_t points;     // all of them
  uint32_t crossings;  // of the left view, with a point or without
};

// Points of the surface that the left view sees, row by row, the first ones where there is no room for all.  rig has
// two cameras.
SurfaceCounts reconstruct_surface(const rvdnav_config& config, const rvdnav_rig& rig, const GreyView& left,
                                  const GreyView& right, SurfaceMemory& memory, rvdnav_surface_point* points,
                                  uint32_t capacity);

}  // namespace rvdnav
