// Refinement of a pose over lines that were fitted to the images of the target's edges, with errors that the lines
// share as parameters beside it.
#pragma once

#include <stdint.h>

#include "arena.hpp"
#include "pose/gauss_newton.hpp"
#include "pose/posterior.hpp"

namespace rvdnav {

struct RefineMemory {
  DirectedLine* lines;  // n
  OffsetTilt* known;    // n
  double* whitening;    // (n, 2, 2)
  double* shift;        // (m)
  double* distances;    // (m)
  double* leverage;     // (m)
  double* U;            // (p, p) factor of the prior's information
  double* mean;         // (p)
  double* z;            // (p)
  double* variances;    // (p)
  double* G;            // (m, p) whitened derivative
  double* Vt;           // (p, m)
  double* VVt;          // (m, m)
  Estimate estimate;
  SolverMemory solver;
  PosteriorMemory posterior;
};

void lay_out(int32_t n, int32_t p, Arena& arena, RefineMemory* memory);

// How a refinement goes on, and how it ended; the memory holds the rest.
struct Refinement {
  Displacement displacement;
  double scales[RVDNAV_MAX_GROUPS];
  SolverOptions options;
  Minimum minimum;
};

rvdnav_status refine_pose(const rvdnav_pose_problem& problem, RefineMemory* memory, Refinement* refinement);

// What it came to, with the memory as it was left; fills what the result's pointers give room for.
rvdnav_status report_pose(const rvdnav_pose_problem& problem, const Refinement& refinement, RefineMemory* memory,
                          rvdnav_refined_pose* result);

}  // namespace rvdnav
