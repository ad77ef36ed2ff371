#include "triangulate.hpp"

#include <Eigen/LU>

namespace rvdnav {

ProjectionMatrix projection_matrix(const RectRig& rig, int32_t camera) {
  const Eigen::Matrix3d R_rect_world = R_world_rect().transpose();
  Eigen::Matrix3d K = Eigen::Matrix3d::Identity();
  K(0, 0) = K(1, 1) = rig.focal;
  ProjectionMatrix M;
  M.leftCols<3>() = K * R_rect_world;
  M.col(3) = -K * rig.centre(camera);
  return M;
}

bool triangulate(const ProjectionMatrix& left, const ProjectionMatrix& right, const Eigen::Vector2d& left_xy,
                 const Eigen::Vector2d& right_xy, Eigen::Vector3d* p_W) {
  Eigen::Matrix<double, 4, 3> K;
  Eigen::Vector4d U;
  const ProjectionMatrix* matrices[2] = {&left, &right};
  const Eigen::Vector2d* points[2] = {&left_xy, &right_xy};
  for (int32_t view = 0; view < 2; ++view) {
    const ProjectionMatrix& M = *matrices[view];
    for (int32_t axis = 0; axis < 2; ++axis) {
      const double x = (*points[view])(axis);
      K.row(2 * view + axis) = x * M.block<1, 3>(2, 0) - M.block<1, 3>(axis, 0);
      U(2 * view + axis) = M(axis, 3) - x * M(2, 3);
    }
  }
  const Eigen::Matrix3d N = K.transpose() * K;
  const double mean = N.trace() / 3.0;
  Eigen::Matrix3d inverse;
  bool invertible = false;
  N.computeInverseWithCheck(inverse, invertible, 1e-9 * mean * mean * mean);
  if (!invertible) return false;
  *p_W = inverse * (K.transpose() * U);
  return p_W->allFinite();
}

}  // namespace rvdnav
