// The target's edges at a pose, measured in the grey values of the views.
#pragma once

#include "arena.hpp"
#include "math/so3.hpp"
#include "navigator/scene.hpp"
#include "target/edge_model.hpp"

namespace rvdnav {

// Profiles across the edges of all views in which a step was found, by view and edge and along it.
struct EdgeSamples {
  Piece* pieces;                   // of the edges that are seen
  rvdnav_seen_edge* seen;          // the same, as they are measured
  rvdnav_edge_coverage* coverage;  // of them
  rvdnav_edge_sample* steps;       // as found
  rvdnav_edge_point* points;       // where they are taken to be
  double* weights;                 // of the points in the fits of lines
  uint32_t* begin;                 // (views x edges + 1): points[begin[i]] is the first one of edge i
  int32_t* attempted;              // (views, edges): profiles on the image
  double* spans;                   // (views, edges, 2, 3): ends of what is seen of an edge, metres in C
  uint32_t piece_count, count;
};

void lay_out(const rvdnav_edge_model& model, int32_t views, Arena& arena, EdgeSamples* samples);

// How the edges are looked for; of arrays (views, edges).
struct SampleRequest {
  double half_width;        // of the profiles, pixels
  const int32_t* polarity;  // of the steps, +1 brighter towards the normal (-dy, dx), -1 darker, 0 either
  const double* face;  // width of the even face that an edge bounds, towards the normal, pixels, 0 unknown; or null
  const double* blur;  // of the steps, pixels; with face
  const double*
      offsets;   // (views, edges, 2) by which the ends lie beside their projections, towards the normal; or null
  double depth;  // by which the edges lie behind those of the model, whole, towards +x_C, metres
};

// RVDNAV_ERROR_BEHIND for a target that is not in front of the cameras, RVDNAV_ERROR_UNDETERMINED if no edge is in
// sight.
rvdnav_status sample_target(const Scene& scene, const math::Transform& T, const SampleRequest& request,
                            EdgeSamples* samples);

}  // namespace rvdnav
