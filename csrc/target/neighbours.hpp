// Edges of a target that run close beside each other in an image: the step of one may be taken for the other's.
//
// The far edge of a face that is seen at a grazing angle, or the back edge of a thin panel, lies within a few pixels of
// the near one.  Which of them the grey values show there, no geometry tells.
#pragma once

#include "pose/view_pose.hpp"
#include "target/edge_model.hpp"

namespace rvdnav {

struct NeighbourMemory {
  Piece* pieces;         // most_pieces of the model
  ProjectedEdge* edges;  // of the model, what is seen of them
  int32_t* number;       // of the edges that are seen
};

// Mean distance, pixels, of the edge next to each along the part where it is near; 0 where there is none.
// separation: of each edge.  False for an edge that is not in front of the camera.
bool neighbour_separation(const rvdnav_edge_model& model, const rvdnav_pose_cameras& cameras, int32_t camera,
                          const math::Transform& T, const NeighbourMemory& memory, double* separation);

}  // namespace rvdnav
