// What is known of target and rig only to a tolerance, as it shows in a frame's lines.
//
// The target's points may lie off by their tolerance, the rig's calibration by its covariance, every frame's steps may
// be displaced towards their bright or their dark side by the camera's response, and edges in all views alike by what
// lies beside them.  The first two are the same in all frames and learnt, the others are each frame's own.
#pragma once

#include "arena.hpp"
#include "math/so3.hpp"
#include "navigator/scene.hpp"

namespace rvdnav {

// Numbers of parameters: the three coordinates of points that are not exact, the calibration's, displaced steps of each
// view, displaced edges, the motion's; those of the frame begin after the lasting ones.
struct ParameterCounts {
  int32_t points, calibration, views, edges, motion;

  int32_t lasting() const { return points + calibration; }
  int32_t all() const { return lasting() + views + edges + motion; }
};

ParameterCounts parameter_counts(const rvdnav_measurement_problem& problem, int32_t views);

struct SystematicsMemory {
  double* derivative;   // (2 x views x edges, p)
  double* information;  // (p, p)
  double* vector;       // (p)
  double* row;          // (2, q)
};

void lay_out(const ParameterCounts& counts, int32_t lines, Arena& arena, SystematicsMemory* memory);

// How far (views, edges, 2), pixels, the ends of the edges are seen beside their projections, towards the normal
// (-dy, dx), with lasting parameters z (q).  False for a target that is not in front of the cameras.
bool lasting_offsets(const Scene& scene, const math::Transform& T, const double* z, const SystematicsMemory& memory,
                     double* offsets);

// What displaced the lines of a frame beyond what lasts: of each line the edge, the side that is brighter (+1 towards
// its normal, -1, 0 unknown), the blur of its step, pixels.
struct LineCircumstances {
  const int32_t* edge;
  const int32_t* polarity;
  const double* blur;
};

// Parameters, their groups and derivatives of a pose problem whose lines are set.  False for an edge that is not in
// front of its camera.
bool set_systematics(const Scene& scene, const math::Transform& T, const LineCircumstances& circumstances,
                     const SystematicsMemory& memory, rvdnav_pose_problem* problem);

}  // namespace rvdnav
