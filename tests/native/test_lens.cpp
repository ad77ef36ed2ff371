#include <doctest/doctest.h>

#include <cmath>
#include <vector>

#include "lens.hpp"
#include "lens_map.hpp"
#include "sample_rig.hpp"

using namespace rvdnav;

TEST_CASE("rect_to_raw is Brown's model after the rectifying rotation") {
  const rvdnav_rig rig = sample_rig();
  for (int camera = 0; camera < 2; ++camera) {
    const rvdnav_camera& c = rig.camera[camera];
    for (double y = -280; y <= 280; y += 70)
      for (double x = -340; x <= 340; x += 85) {
        // The ray in the camera: the rotation's columns are the rectified axes' projections.
        double ray[3];
        for (int k = 0; k < 3; ++k)
          ray[k] = c.R_rect_cam[k] * x + c.R_rect_cam[3 + k] * y + c.R_rect_cam[6 + k] * rig.focal_rect;
        const double a = ray[0] / ray[2], b = ray[1] / ray[2], r2 = a * a + b * b;
        const double radial = 1 + c.k1 * r2 + c.k2 * r2 * r2;
        double u = 0, v = 0;
        rect_to_raw(rig, camera, x, y, &u, &v);
        CHECK(u == doctest::Approx(c.fx * (a * radial + 2 * c.p1 * a * b + c.p2 * (r2 + 2 * a * a)) + c.cx));
        CHECK(v == doctest::Approx(c.fy * (b * radial + c.p1 * (r2 + 2 * b * b) + 2 * c.p2 * a * b) + c.cy));
      }
  }
}

TEST_CASE("raw_to_rect inverts rect_to_raw over the whole image") {
  const rvdnav_rig rig = sample_rig();
  for (int camera = 0; camera < 2; ++camera)
    for (int v = 0; v < rig.height; v += 25)
      for (int u = 0; u < rig.width; u += 25) {
        double x = 0, y = 0, u2 = 0, v2 = 0;
        REQUIRE(raw_to_rect(rig, camera, u, v, &x, &y));
        rect_to_raw(rig, camera, x, y, &u2, &v2);
        CHECK(std::hypot(u2 - u, v2 - v) < 1e-9);
      }
}

TEST_CASE("raw_to_rect says where there is no rectified point") {
  rvdnav_rig rig = sample_rig();
  double x = 0, y = 0;
  rig.camera[0].k1 = -1.5;  // folds over well inside the image
  rig.camera[0].k2 = 0.0;
  CHECK(!raw_to_rect(rig, 0, 0, 0, &x, &y));
  rig = sample_rig();
  for (double& r : rig.camera[0].R_rect_cam) r = -r;  // looks backwards
  CHECK(!raw_to_rect(rig, 0, 350, 280, &x, &y));
}

TEST_CASE("the lens map stays within 0.015 pixels of the lens and its rounding") {
  const rvdnav_rig rig = sample_rig();
  for (int camera = 0; camera < 2; ++camera) {
    std::vector<int16_t> nodes(map_length(rig.width, rig.height));
    CHECK(nodes.size() * sizeof nodes[0] <= 27 * 1024);
    LensMap map = {};
    REQUIRE(build_lens_map(rig, camera, nodes.data(), &map));
    double worst = 0, sum = 0;
    int count = 0;
    for (int v = 0; v < rig.height; v += 3)
      for (int u = 0; u < rig.width; ++u) {
        const int32_t u_q5 = 32 * u + v % 32, v_q5 = 32 * v + u % 32;
        int32_t xq = 0, yq = 0;
        raw_to_rect_q5(map, u_q5, v_q5, &xq, &yq);
        double x = 0, y = 0;
        REQUIRE(raw_to_rect(rig, camera, u_q5 / 32.0, v_q5 / 32.0, &x, &y));
        worst = std::fmax(worst, std::fmax(std::fabs(xq / 32.0 - x), std::fabs(yq / 32.0 - y)));
        sum += std::hypot(xq / 32.0 - x, yq / 32.0 - y);
        ++count;
      }
    CHECK(worst < 0.015 + 1.0 / 64.0);
    CHECK(sum / count < 0.014);  // the rounding alone gives 0.012
  }
}

TEST_CASE("the lens map goes on straight outside the image") {
  const rvdnav_rig rig = sample_rig();
  std::vector<int16_t> nodes(map_length(rig.width, rig.height));
  LensMap map = {};
  REQUIRE(build_lens_map(rig, 0, nodes.data(), &map));
  for (const auto& [u, v] : {std::pair{-4, -4}, {707, 579}, {-4, 300}, {350, 579}}) {
    int32_t xq = 0, yq = 0;
    raw_to_rect_q5(map, 32 * u, 32 * v, &xq, &yq);
    double x = 0, y = 0;
    REQUIRE(raw_to_rect(rig, 0, u, v, &x, &y));
    CHECK(std::hypot(xq / 32.0 - x, yq / 32.0 - y) < 0.2);
  }
}

TEST_CASE("a lens that cannot be mapped is refused") {
  rvdnav_rig rig = sample_rig();
  std::vector<int16_t> nodes(map_length(rig.width, rig.height));
  LensMap map = {};
  rig.focal_rect = 2100.0;  // spreads the image beyond 1023 pixels
  CHECK(!build_lens_map(rig, 0, nodes.data(), &map));
  rig = sample_rig();
  rig.camera[0].k1 = -1.5;
  CHECK(!build_lens_map(rig, 0, nodes.data(), &map));
  CHECK(build_lens_map(rig, 1, nodes.data(), &map));
}
