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
        REQUIRE(raw_to_rect_q5(map, u_q5, v_q5, &xq, &yq));
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
    REQUIRE(raw_to_rect_q5(map, 32 * u, 32 * v, &xq, &yq));
    double x = 0, y = 0;
    REQUIRE(raw_to_rect(rig, 0, u, v, &x, &y));
    CHECK(std::hypot(xq / 32.0 - x, yq / 32.0 - y) < 0.2);
  }
}

TEST_CASE("a lens that cannot be mapped is refused") {
  rvdnav_rig rig = sample_rig();
  std::vector<int16_t> nodes(map_length(rig.width, rig.height));
  LensMap map = {};
  rig.focal_rect = 12000.0;  // spreads the image beyond 8191 pixels
  CHECK(!build_lens_map(rig, 0, nodes.data(), &map));
  rig = sample_rig();
  for (double& r : rig.camera[0].R_rect_cam) r = -r;  // sees nothing of the rectified view
  CHECK(!build_lens_map(rig, 0, nodes.data(), &map));
  CHECK(build_lens_map(rig, 1, nodes.data(), &map));
}

namespace {

// One camera that looks straight ahead.
rvdnav_rig straight_rig(int32_t width, int32_t height, double focal, double k1) {
  rvdnav_rig rig = {};
  rig.struct_size = sizeof rig;
  rig.width = width;
  rig.height = height;
  rig.camera_count = 1;
  rig.focal_rect = focal;
  rig.camera[0] = {focal, focal, (width - 1) / 2.0, (height - 1) / 2.0, k1, 0, 0, 0, {1, 0, 0, 0, 1, 0, 0, 0, 1}};
  return rig;
}

// r (1 + k1 r^2) grows up to r = sqrt(-1 / (3 k1)), where it is two thirds of that.
double k1_that_folds_at(double distorted) { return -4.0 / (27.0 * distorted * distorted); }

}  // namespace

TEST_CASE("a lens that folds just outside the image has a ray for every pixel") {
  // 704 x 576: the last nodes lie 1 and 1 pixel outside; 698 x 570: 6 pixels.
  for (const auto& [width, height] : {std::pair{704, 576}, {698, 570}, {697, 569}}) {
    const double corner = std::hypot((width - 1) / 2.0, (height - 1) / 2.0);
    const rvdnav_rig rig = straight_rig(width, height, 600.0, k1_that_folds_at((corner + 0.5) / 600.0));
    std::vector<int16_t> nodes(map_length(width, height));
    LensMap map = {};
    REQUIRE(build_lens_map(rig, 0, nodes.data(), &map));
    for (const auto& [u, v] : {std::pair{0, 0}, {width - 1, 0}, {0, height - 1}, {width - 1, height - 1}, {350, 280}}) {
      int32_t xq = 0, yq = 0;
      REQUIRE(raw_to_rect_q5(map, 32 * u, 32 * v, &xq, &yq));
      double x = 0, y = 0;
      REQUIRE(raw_to_rect(rig, 0, u, v, &x, &y));
      CHECK(std::hypot(xq / 32.0 - x, yq / 32.0 - y) < 0.2);
    }
  }
}

TEST_CASE("pixels beyond the fold have no ray, the others keep theirs") {
  const rvdnav_rig rig = straight_rig(704, 576, 600.0, k1_that_folds_at(430.0 / 600.0));  // the corners lie at 454
  std::vector<int16_t> nodes(map_length(rig.width, rig.height));
  LensMap map = {};
  REQUIRE(build_lens_map(rig, 0, nodes.data(), &map));
  for (int v = 0; v < rig.height; v += 5) {
    for (int u = 0; u < rig.width; u += 5) {
      const double radius = std::hypot(u - 351.5, v - 287.5);
      int32_t xq = 0, yq = 0;
      const bool mapped = raw_to_rect_q5(map, 32 * u, 32 * v, &xq, &yq);
      if (radius > 430.0) REQUIRE(!mapped);
      if (radius < 430.0 - 12.0) REQUIRE(mapped);  // a cell's diagonal
    }
  }
}

TEST_CASE("beyond the fold nothing is imaged") {
  const rvdnav_rig rig = straight_rig(704, 576, 600.0, k1_that_folds_at(430.0 / 600.0));
  const double fold = 1.5 * 430.0;  // rectified pixels
  double u = 0, v = 0;
  rect_to_raw(rig, 0, 0.99 * fold, 0.0, &u, &v);
  CHECK(u == doctest::Approx(351.5 + 430.0).epsilon(1e-3));
  rect_to_raw(rig, 0, 1.01 * fold, 0.0, &u, &v);
  CHECK(std::isnan(u));
  rect_to_raw(rig, 0, 1.7 * fold, 0.0, &u, &v);  // the polynomial passes through the middle of the image here
  CHECK(std::isnan(v));
}

TEST_CASE("images up to 4096 x 3072 are mapped, also regions far from the axis") {
  for (const double off_axis : {0.0, 1400.0, 2500.0}) {
    rvdnav_rig rig = straight_rig(4096, 3072, 3800.0, -0.1);
    if (off_axis > 0.0) rig = straight_rig(704, 576, 3800.0, -0.1);
    rig.camera[0].cx += off_axis;
    std::vector<int16_t> nodes(map_length(rig.width, rig.height));
    LensMap map = {};
    REQUIRE(build_lens_map(rig, 0, nodes.data(), &map));
    double farthest = 0;
    for (int v = 0; v < rig.height; v += 125) {
      for (int u = 0; u < rig.width; u += 125) {
        int32_t xq = 0, yq = 0;
        REQUIRE(raw_to_rect_q5(map, 32 * u, 32 * v, &xq, &yq));
        double x = 0, y = 0;
        REQUIRE(raw_to_rect(rig, 0, u, v, &x, &y));
        CHECK(std::hypot(xq / 32.0 - x, yq / 32.0 - y) < 0.1);  // nodes as coarse as 1/8 pixel
        farthest = std::fmax(farthest, std::hypot(x, y));
      }
    }
    const double reach = rectified_reach(rig, 0);
    CHECK(reach >= farthest);
    CHECK(reach < 1.2 * farthest);
  }
}
