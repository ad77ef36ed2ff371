#include <doctest/doctest.h>

#include <cmath>
#include <vector>

#include "lens.hpp"
#include "plain.hpp"
#include "rectify.hpp"
#include "sample_rig.hpp"

using namespace rvdnav;

namespace {

struct Scene {
  rvdnav_rig rig = sample_rig();
  std::vector<int16_t> nodes = std::vector<int16_t>(map_length(rig.width, rig.height));
  LensMap map = {};
  plain::BitImage bits{rig.width, rig.height};
  std::vector<uint8_t> direction = std::vector<uint8_t>(static_cast<size_t>(rig.width * rig.height));

  explicit Scene(int camera) {
    REQUIRE(build_lens_map(rig, camera, nodes.data(), &map));
    plain::Random random(7);
    for (int i = 0; i < 3000; ++i) {
      const int32_t x = random.between(0, rig.width - 1), y = random.between(0, rig.height - 1);
      bits.put(x, y, true);
      direction[static_cast<size_t>(y * rig.width + x)] = static_cast<uint8_t>(random.between(0, 255));
    }
  }
};

}  // namespace

TEST_CASE("rectify_edges maps places and directions like the exact lens, row by row") {
  for (int camera = 0; camera < 2; ++camera) {
    const Scene scene(camera);
    std::vector<rvdnav_edgel> edgels(3000);
    uint32_t total = 0;
    const uint32_t n = rectify_edges(scene.bits.words.data(), scene.direction.data(), scene.rig.width, scene.rig.height,
                                     scene.map, *select_kernels(RVDNAV_ISA_AUTO), edgels.data(), 3000, &total);
    REQUIRE(n == static_cast<uint32_t>(scene.bits.count()));
    REQUIRE(total == n);
    size_t i = 0;
    double turned = 0;
    for (int32_t y = 0; y < scene.rig.height; ++y)
      for (int32_t x = 0; x < scene.rig.width; ++x) {
        if (!scene.bits.get(x, y)) continue;
        const rvdnav_edgel& e = edgels[i++];
        double ex = 0, ey = 0;
        REQUIRE(raw_to_rect(scene.rig, camera, x, y, &ex, &ey));
        REQUIRE(std::fabs(e.x_q5 / 32.0 - ex) < 0.031);
        REQUIRE(std::fabs(e.y_q5 / 32.0 - ey) < 0.031);
        // The tangent's image under the lens, by a small step.
        const double raw = scene.direction[static_cast<size_t>(y * scene.rig.width + x)] * M_PI / 128.0;
        double ax = 0, ay = 0, bx = 0, by = 0;
        REQUIRE(raw_to_rect(scene.rig, camera, x - std::sin(raw) * 0.01, y + std::cos(raw) * 0.01, &ax, &ay));
        REQUIRE(raw_to_rect(scene.rig, camera, x + std::sin(raw) * 0.01, y - std::cos(raw) * 0.01, &bx, &by));
        const double expected = std::atan2(ay - by, ax - bx) - M_PI / 2;
        REQUIRE(std::fabs(std::remainder(e.direction - expected * 128.0 / M_PI, 256.0)) < 1.5);
        turned = std::fmax(turned, std::fabs(std::remainder(expected - raw, 2 * M_PI)));
      }
    CHECK(turned * 180.0 / M_PI > 2.0);  // so that the test could tell
  }
}

TEST_CASE("rectify_edges keeps within its capacity and counts what there is") {
  const Scene scene(0);
  std::vector<rvdnav_edgel> all(3000), few(101, rvdnav_edgel{1, 2, 3, 4});
  uint32_t total = 0;
  rectify_edges(scene.bits.words.data(), scene.direction.data(), scene.rig.width, scene.rig.height, scene.map,
                *select_kernels(RVDNAV_ISA_AUTO), all.data(), 3000, &total);
  const uint32_t expected = total;
  CHECK(rectify_edges(scene.bits.words.data(), scene.direction.data(), scene.rig.width, scene.rig.height, scene.map,
                      *select_kernels(RVDNAV_ISA_AUTO), few.data(), 100, &total) == 100);
  CHECK(total == expected);
  for (size_t i = 0; i < 100; ++i) {
    CHECK(few[i].x_q5 == all[i].x_q5);
    CHECK(few[i].y_q5 == all[i].y_q5);
  }
  CHECK(few[100].x_q5 == 1);
}
