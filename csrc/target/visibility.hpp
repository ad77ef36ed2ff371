// Which parts of a target's edges an eye sees: edges of faces that look away and what lies behind faces is hidden.
#pragma once

#include "target/edge_model.hpp"

namespace rvdnav {

// Sine of the elevation of the eye above a face below which its far edges can't be told from the near ones, and a small
// error of the pose would hide them: 3 degrees.
constexpr double kGrazing = 0.052335956242943835;

// The most parts of a model's edges that one view can show.
uint32_t most_pieces(const rvdnav_edge_model& model);

// What an eye (3) in C sees of the edges, by edge; as many pieces as most_pieces at most, and returns how many.
// least_elevation: sine of the angle by which it must stand above a face for its edges to count.
uint32_t visible_pieces(const rvdnav_edge_model& model, const double* eye, double least_elevation, int32_t camera,
                        Piece* pieces);

}  // namespace rvdnav
