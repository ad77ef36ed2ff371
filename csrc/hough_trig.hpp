// Cosines and sines of Hough space, Q14, in steps of half a degree.
#pragma once

#include "angle.hpp"

namespace rvdnav {

struct HoughTrig {
  UnitQ14 half_degree[360];  // of -45, -44.5, ... 134.5 degrees
};

constexpr HoughTrig make_hough_trig() {
  HoughTrig table = {};
  for (int32_t i = 0; i < 360; ++i) table.half_degree[i] = unit_q14(-45.0 + i * 0.5);
  return table;
}

inline constexpr HoughTrig kHoughTrig = make_hough_trig();

}  // namespace rvdnav
