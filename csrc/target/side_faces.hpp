// A bracket's side faces: where one is in sight, the step seen at an edge of the front face may be the far end of it.
//
// The bars reach back from the front face by their thickness.  From a camera that looks past an edge the front face
// ends in the background and the step is the edge itself.  From one that sees the side face too, the step lies at the
// front edge, at the back edge, or in between, as the light on the side face has it: nothing in the geometry tells
// which.
#pragma once

#include "pose/view_pose.hpp"
#include "target/edge_model.hpp"

namespace rvdnav {

// How far, pixels, the back edge is seen beside the middle of an edge towards a normal (2) of the image; 0 where the
// side face is out of sight.  False for an edge that is not in front of the camera.
bool side_separation(const rvdnav_edge_model& model, const ViewPose& view, int32_t edge, const double* normal,
                     double* separation);

}  // namespace rvdnav
