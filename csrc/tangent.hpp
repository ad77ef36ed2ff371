// The tangent of an edge by its gradient's direction.
#pragma once

#include "angle.hpp"

namespace rvdnav {

constexpr int32_t kTangentReach = 4;  // pixels to both sides

struct TangentStep {
  int16_t dx, dy;  // Q5
};

struct TangentTable {
  TangentStep step[256];
};

constexpr TangentTable make_tangent_table() {
  TangentTable table = {};
  for (int32_t level = 0; level < 256; ++level) {
    const CosSin gradient = cos_sin_degrees(level * (360.0 / 256.0));
    table.step[level] = {static_cast<int16_t>(round_half_away(-gradient.s * (kTangentReach * 32))),
                         static_cast<int16_t>(round_half_away(gradient.c * (kTangentReach * 32)))};
  }
  return table;
}

inline constexpr TangentTable kTangent = make_tangent_table();

}  // namespace rvdnav
