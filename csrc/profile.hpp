// Stage 7: where a straight edge lies in the raw grey values, by a blurred-step model across it.
#pragma once

#include <cstdint>

#include "line2.hpp"
#include "rvdnav/rvdnav.h"
#include "types.hpp"

namespace rvdnav {

struct ProfileSettings {
  double half_width;  // pixels to both sides of the model edge, 1 .. kMaxHalfWidth
  double step;        // pixels between profiles along the edge
  double blur_sigma;  // pixels
};

constexpr double kMaxHalfWidth = 12.0;

struct ProfileCount {
  uint32_t found;     // usable steps, of which the first ones were written
  uint32_t on_image;  // profiles whose middle lies on the image
};

// One profile every step pixels; those off the image or without a usable step are left out.  Samples carry edge_index;
// as many as capacity are written.
ProfileCount measure_edge(const rvdnav_rig& rig, int32_t camera, const GreyView& image, const rvdnav_model_edge& edge,
                          int32_t edge_index, const ProfileSettings& settings, rvdnav_edge_sample* samples,
                          uint32_t capacity);

}  // namespace rvdnav
