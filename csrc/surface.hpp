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

// Points of the surface that the left view sees, row by row.  Returns the number written, at most capacity (the first
// ones); *total counts all.  rig has two cameras.
uint32_t reconstruct_surface(const rvdnav_config& config, const rvdnav_rig& rig, const GreyView& left,
                             const GreyView& right, SurfaceMemory& memory, rvdnav_surface_point* points,
                             uint32_t capacity, uint32_t* total);

}  // namespace rvdnav
