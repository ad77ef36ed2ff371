// What a refined frame tells of the errors that last, and what of its own error is the frame's alone.
#pragma once

#include "arena.hpp"
#include "navigator/systematics.hpp"

namespace rvdnav {

struct LearningMemory {
  double* A;          // (k, k) of the pose and the frame's own parameters
  double* B;          // (k, q + 1) of them and the lasting ones, and their pull
  double* selected;   // (k, 6): the pose among them
  double* prior;      // (q, q) of the lasting parameters before the frame
  double* posterior;  // (q, q) after it
  double* reach;      // (q, 6) of the pose by the lasting parameters, twice
};

void lay_out(const ParameterCounts& counts, Arena& arena, LearningMemory* memory);

// Own covariance and what the measurement teaches of the lasting parameters, from its refined pose; with what errs in
// all points alike, as where their lengths were measured from one end, which no line shows, added to the pose's
// covariance.  False if no such covariance exists.
bool learn_from_frame(const Scene& scene, LearningMemory* memory, rvdnav_measurement* measurement);

}  // namespace rvdnav
