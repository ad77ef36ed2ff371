// The lens the other way round: a coarse grid from rectified to raw pixels, for resampling whole images.
#pragma once

#include "rvdnav/rvdnav.h"
#include "types.hpp"

namespace rvdnav {

constexpr int32_t kRectStep = 8;       // pixels between nodes
constexpr int32_t kRectFraction = 12;  // raw positions count 2^-12 pixels

// Column i and row j of the rectified image lie at x = i - (width - 1) / 2, y = j - (height - 1) / 2.
struct RectMap {
  int32_t* nodes;  // pairs u, v in Q12, row-major
  int32_t columns, rows;
};

constexpr int32_t rect_map_columns(int32_t width) { return (width - 1) / kRectStep + 2; }

// int32 values that the nodes of an image need.
constexpr size_t rect_map_length(int32_t width, int32_t height) {
  return size_t{2} * static_cast<size_t>(rect_map_columns(width)) * static_cast<size_t>(rect_map_columns(height));
}

// map.nodes: rect_map_length values.  A rectified point that no camera of this kind images gets a raw position far
// outside.
void build_rect_map(const rvdnav_rig& rig, int32_t camera, RectMap* map);

// Raw positions, Q12, of row j's columns 0 .. width - 1; bilinear between the nodes.
void rect_row_to_raw(const RectMap& map, int32_t j, int32_t width, int32_t* u, int32_t* v);

}  // namespace rvdnav
