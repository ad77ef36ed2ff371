#include <doctest/doctest.h>

#include <Eigen/Geometry>

#include "plain.hpp"
#include "scene.hpp"
#include "triangulate.hpp"

using namespace rvdnav;

namespace {

const RectRig kRig = {scene::kFocal, scene::kBaseline};

Eigen::Vector3d point_in_front(plain::Random& random) {
  return {random.real(0.25, 1.7), random.real(-0.4, 0.4), random.real(-0.4, 0.5)};
}

// Pixels of a world point by similar triangles: x_W is the depth, z_W grows to the left.
Eigen::Vector2d seen(int camera, const Eigen::Vector3d& p_W) {
  const double z = p_W.z() - (camera == 0 ? kRig.baseline : 0.0);
  return {-kRig.focal * z / p_W.x(), kRig.focal * p_W.y() / p_W.x()};
}

}  // namespace

TEST_CASE("projection matrices project") {
  plain::Random random(110);
  for (int i = 0; i < 50; ++i) {
    const Eigen::Vector3d p = point_in_front(random);
    for (int camera = 0; camera < 2; ++camera) {
      const Eigen::Vector3d h = projection_matrix(kRig, camera) * p.homogeneous();
      CHECK((h.hnormalized() - seen(camera, p)).norm() < 1e-9);
      CHECK(h.z() == doctest::Approx(p.x()));
    }
  }
}

TEST_CASE("exact points come back exactly") {
  plain::Random random(111);
  const ProjectionMatrix left = projection_matrix(kRig, 0), right = projection_matrix(kRig, 1);
  for (int i = 0; i < 200; ++i) {
    const Eigen::Vector3d p = point_in_front(random);
    Eigen::Vector3d found;
    REQUIRE(triangulate(left, right, seen(0, p), seen(1, p), &found));
    CHECK((found - p).norm() < 1e-9);
  }
}

TEST_CASE("noisy points are the least squares solution of the paper's equations") {
  plain::Random random(112);
  const ProjectionMatrix M[2] = {projection_matrix(kRig, 0), projection_matrix(kRig, 1)};
  for (int i = 0; i < 50; ++i) {
    const Eigen::Vector3d p = point_in_front(random);
    Eigen::Vector2d xy[2];
    for (int camera = 0; camera < 2; ++camera)
      xy[camera] = seen(camera, p) + Eigen::Vector2d(random.real(-1, 1), random.real(-1, 1));
    Eigen::Vector3d found;
    REQUIRE(triangulate(M[0], M[1], xy[0], xy[1], &found));
    const auto cost = [&](const Eigen::Vector3d& q) {
      double sum = 0.0;
      for (int camera = 0; camera < 2; ++camera) {
        const Eigen::Vector3d h = M[camera] * q.homogeneous();
        sum += (xy[camera] * h.z() - h.head<2>()).squaredNorm();
      }
      return sum;
    };
    for (int k = 0; k < 3; ++k) {
      for (const double step : {-1e-5, 1e-5}) CHECK(cost(found + step * Eigen::Vector3d::Unit(k)) > cost(found));
    }
  }
}

TEST_CASE("parallel rays meet nowhere") {
  Eigen::Vector3d p;
  const ProjectionMatrix left = projection_matrix(kRig, 0), right = projection_matrix(kRig, 1);
  CHECK_FALSE(triangulate(left, right, {30.0, 12.0}, {30.0, 12.0}, &p));
  CHECK_FALSE(triangulate(left, left, {30.0, 12.0}, {30.0, 12.0}, &p));
}
