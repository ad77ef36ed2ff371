// The edges measured where a pose puts them: samples, lines through them, and what may have displaced these.
#pragma once

#include "arena.hpp"
#include "navigator/edge_samples.hpp"
#include "pose/edge_lines.hpp"
#include "target/neighbours.hpp"

namespace rvdnav {

// n lines, by view and edge.
struct MeasuredLines {
  EdgeSamples samples;
  rvdnav_edge_line* fits;   // through the samples
  rvdnav_pose_line* lines;  // the same, for the refinement
  int32_t* edge;
  int32_t* polarity;  // +1 where most of the samples are brighter towards the normal, -1 darker
  int32_t n;
};

struct MeasuringMemory {
  EdgeSamples beside;  // of other steps than the edges' own
  rvdnav_edge_line* beside_fits;
  EdgeLineMemory fit;
  NeighbourMemory neighbours;
  double* scratch;     // of the samples
  double* moved;       // (views, edges), pixels
  double* separation;  // the same
  double* offsets;     // (views, edges, 2), pixels
  int32_t* opposite;   // (views, edges)
};

void lay_out(const rvdnav_edge_model& model, int32_t views, Arena& arena, MeasuredLines* lines,
             MeasuringMemory* memory);

// How the edges are looked for at a pose; arrays as of SampleRequest, none of them null.
struct MeasuringRequest {
  double half_width;
  const int32_t* polarity;
  const double* face;
  const double* blur;
  const double* offsets;
};

// A status as of sample_target.
rvdnav_status measure_lines(const Scene& scene, const math::Transform& T, const MeasuringRequest& request,
                            MeasuringMemory* memory, MeasuredLines* lines);

// Distances (2), pixels, of the ends of what was seen of a fitted edge, depth metres behind it, from its line.  False
// if they are not in front of the camera.
bool end_distances(const Scene& scene, const math::Transform& T, const rvdnav_edge_line& fit, const double* span,
                   double depth, double* distances);

}  // namespace rvdnav
