// Stage 9: points in space from both views.
#pragma once

#include <Eigen/Core>

#include "rect_rig.hpp"

namespace rvdnav {

using ProjectionMatrix = Eigen::Matrix<double, 3, 4>;

// The paper's M_l or M_r of a rectified camera: homogeneous points in W to homogeneous rectified pixels.
ProjectionMatrix projection_matrix(const RectRig& rig, int32_t camera);

// Least squares of the paper's equations (1)-(3): the depths eliminated, K p_W = U, p_W = (K^T K)^-1 K^T U.  False when
// the rays are too close to parallel.
bool triangulate(const ProjectionMatrix& left, const ProjectionMatrix& right, const Eigen::Vector2d& left_xy,
                 const Eigen::Vector2d& right_xy, Eigen::Vector3d* p_W);

}  // namespace rvdnav
