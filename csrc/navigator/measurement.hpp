// One frame's measurement: from a coarse pose to a refined one with its evidence.
#pragma once

#include "navigator/learning.hpp"
#include "navigator/measured_lines.hpp"
#include "navigator/systematics.hpp"
#include "pose/refine.hpp"

namespace rvdnav {

struct MeasurementMemory {
  MeasuredLines lines;
  MeasuringMemory measuring;
  SystematicsMemory systematics;
  RefineMemory refine;
  LearningMemory learning;
  double* face;      // (views, edges) widths, pixels
  double* blur;      // (views, edges) pixels
  double* least;     // the same, of the steps as they seem at first
  double* found;     // the same, before a larger one is tried
  double* tried;     // 1 where one is, else 0
  double* offsets;   // (views, edges, 2) pixels
  double* own_blur;  // of each line, pixels
  int32_t* either;   // (views, edges) zeros: steps of either polarity
};

void lay_out(const rvdnav_measurement_problem& problem, int32_t views, Arena& arena, MeasurementMemory* memory);

// The pose that the frame's grey values give around the problem's.  RVDNAV_ERROR_UNDETERMINED, _BEHIND or _NO_AGREEMENT
// where they give none.
rvdnav_status measure(const Scene& scene, MeasurementMemory* memory, rvdnav_measurement* measurement);

}  // namespace rvdnav
