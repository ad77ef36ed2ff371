// The lens in fixed point: a coarse grid from raw to rectified pixels.
#pragma once

#include "rvdnav/rvdnav.h"
#include "types.hpp"

namespace rvdnav {

constexpr int32_t kMapStep = 8;        // pixels between nodes
constexpr double kMaxRect = 8191.0;    // distance of rectified pixels from the principal point
constexpr int16_t kNoRay = INT16_MIN;  // first value of a node without a rectified point

// A node holds how far its rectified point lies from its raw one (both from the middle of the image), x and y.  That is
// small, so that 16 bits hold it much finer than the coordinates themselves.
struct LensMap {
  const int16_t* nodes;  // pairs, row-major
  int32_t columns, rows;
  bool complete;               // every node has a ray
  int32_t shift;               // of the nodes: units of 2^-shift pixels, 3..12
  int32_t middle_x, middle_y;  // of the raw image, Q5
};

constexpr int32_t map_columns(int32_t width) { return (width - 1) / kMapStep + 2; }

// int16 values that the nodes of an image need.
constexpr size_t map_length(int32_t width, int32_t height) {
  return size_t{2} * static_cast<size_t>(map_columns(width)) * static_cast<size_t>(map_columns(height));
}

// Largest distance from the principal point of a rectified pixel of the view; 0 where no node has a ray.
double rectified_reach(const rvdnav_rig& rig, int32_t camera);

// nodes: map_length values, kept by the caller.  Pixels near a node without a ray have none either.  False if the lens
// cannot be mapped: no ray at all, or one beyond kMaxRect or farther from its pixel than 16 bits hold.
bool build_lens_map(const rvdnav_rig& rig, int32_t camera, int16_t* nodes, LensMap* map);

// Bilinear between the nodes; goes on straight outside.  Inside the image the grid is wrong by at most 0.015 pixels
// (with a lens that bends the corners by 50 pixels), and the result is rounded to 1/32 pixel.  False where there is no
// ray.
bool raw_to_rect_q5(const LensMap& map, int32_t u_q5, int32_t v_q5, int32_t* x_q5, int32_t* y_q5);

}  // namespace rvdnav
