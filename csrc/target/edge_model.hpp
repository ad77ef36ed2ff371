// A target's straight edges in the capture frame C.
#pragma once

#include <stddef.h>
#include <stdint.h>

#include "rvdnav/rvdnav.h"

namespace rvdnav {

// The first (0) or second (1) end of an edge, metres.
inline const double* edge_end(const rvdnav_edge_model& model, int32_t edge, int32_t end) {
  return model.points + static_cast<ptrdiff_t>(3) * model.ends[2 * edge + end];
}

// Where along an edge a point lies: 0 at the first end, 1 at the second.
inline double part_along(const rvdnav_edge_model& model, int32_t edge, const double* point) {
  const double *from = edge_end(model, edge, 0), *to = edge_end(model, edge, 1);
  double product = 0.0, square = 0.0;
  for (int32_t i = 0; i < 3; ++i) {
    product += (point[i] - from[i]) * (to[i] - from[i]);
    square += (to[i] - from[i]) * (to[i] - from[i]);
  }
  return product / square;
}

// A part of an edge that is seen in one view.
struct Piece {
  double ends[2][3];  // metres, in the direction of the edge
  int32_t edge;
  int32_t camera;
};

}  // namespace rvdnav
