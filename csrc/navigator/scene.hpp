// A frame's images beside what is known of rig and target: what every step of a measurement looks at.
#pragma once

#include "rvdnav/rvdnav.h"
#include "types.hpp"

namespace rvdnav {

struct Scene {
  const rvdnav_rig* rig;
  const rvdnav_measurement_problem* problem;
  GreyView images[RVDNAV_CAMERAS];
  bool present[RVDNAV_CAMERAS];
  double blur_sigma;  // of a step in a sharp image, pixels
  int32_t views, edges;

  const rvdnav_edge_model& model() const { return *problem->model; }
  bool is_bracket() const { return problem->model->bracket != 0; }
  bool is_rolling() const { return problem->motion.row_seconds > 0.0; }
  // Arrays (views, edges) have so many elements, an edge in a view this one.
  int32_t size() const { return views * edges; }
  int32_t index(int32_t camera, int32_t edge) const { return camera * edges + edge; }
};

}  // namespace rvdnav
