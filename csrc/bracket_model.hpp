// The bracket's front face as edges, bars and the cyclic order of its corners.
#pragma once

#include <cstdint>

#include <Eigen/Core>

#include "rvdnav/rvdnav.h"

namespace rvdnav {

struct BracketModel {
  struct Edge {
    Eigen::Vector3d a, b;  // ends in C, in the direction P1 -> P2 -> P3 -> P4 around the frame
  };
  // Edge 2 k is the outer, 2 k + 1 the inner one of bar k; bars are l1, l2, l3, l4.
  Edge edge[RVDNAV_EDGES];
  // The side face behind each edge reaches back by this; its normal points away from the bar's other edge.
  Eigen::Vector3d back;
  Eigen::Vector3d outward[RVDNAV_EDGES];
  // Where the centre lines of a bar and of the bars before and after it meet.
  Eigen::Vector3d axis_start[RVDNAV_BARS];
  Eigen::Vector3d axis_end[RVDNAV_BARS];
  double bar_width[RVDNAV_BARS];
};

// Neighbours around the frame l1 -> l3 -> l2 -> l4.
constexpr int32_t kNextBar[RVDNAV_BARS] = {2, 3, 1, 0};
constexpr int32_t kPreviousBar[RVDNAV_BARS] = {3, 2, 0, 1};
// Apex (0..3) at the start and the end of each bar.
constexpr int32_t kStartApex[RVDNAV_BARS] = {0, 2, 1, 3};
constexpr int32_t kEndApex[RVDNAV_BARS] = {1, 3, 2, 0};

BracketModel make_bracket_model(const rvdnav_target& target);

}  // namespace rvdnav
