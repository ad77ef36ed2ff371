// Straight lines through the places where each edge was found: robust fits that tell an edge's own scatter from its
// outliers.
#pragma once

#include <stdint.h>

#include "arena.hpp"
#include "rvdnav/rvdnav.h"

namespace rvdnav {

struct EdgeLineMemory {
  uint32_t* order;  // of the points by camera and edge
  double* across;   // of one edge's points from their mean
  double* along;
  double* noise;
  double* weight;
  double* tukey;
  double* scratch;
};

void lay_out(uint32_t point_count, Arena& arena, EdgeLineMemory* memory);

// One line for each edge and camera whose points agree well enough, in that order.  The points of an
// edge come in their order along it: how alike neighbours are tells how many are independent.
// weights (point_count): of the points in their line's fit, 0 for outliers and for edges without a line.  Writes at
// most capacity lines and returns how many; *total: how many there are.
uint32_t fit_edge_lines(const rvdnav_edge_point* points, uint32_t point_count, const EdgeLineMemory& memory,
                        rvdnav_edge_line* lines, uint32_t capacity, double* weights, uint32_t* total);

}  // namespace rvdnav
