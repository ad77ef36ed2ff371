// A matched pair of crossings as a point in space with its standard deviation.
#pragma once

#include "crossing_match.hpp"
#include "triangulate.hpp"

namespace rvdnav {

struct SurfaceGeometry {
  RectRig rig;
  ProjectionMatrix left, right;  // projection matrices
};

// False when the pair cannot be triangulated.
bool make_surface_point(const LevelView& left, const LevelView& right, int32_t y, const CrossingMatch& match,
                        const Crossing& left_crossing, const SurfaceGeometry& geometry, rvdnav_surface_point* point);

}  // namespace rvdnav
