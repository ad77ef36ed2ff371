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

// Rows of a degree for every window of rows that an edgel votes in: row i is row i % 180 of the accumulator.
struct HoughRows {
  int32_t c[288], s[288];
};

constexpr HoughRows make_hough_rows() {
  HoughRows rows = {};
  for (int32_t i = 0; i < 288; ++i) {
    rows.c[i] = kHoughTrig.half_degree[2 * (i % 180)].c;
    rows.s[i] = kHoughTrig.half_degree[2 * (i % 180)].s;
  }
  return rows;
}

inline constexpr HoughRows kHoughRows = make_hough_rows();

}  // namespace rvdnav
