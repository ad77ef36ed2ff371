#include <doctest/doctest.h>

#include <algorithm>
#include <cmath>
#include <vector>

#include "plain.hpp"
#include "pyramid.hpp"

using namespace rvdnav;

namespace {

using Plane = std::vector<double>;

// One level with memory of its own.
struct Level {
  std::vector<uint16_t> grey, smoothed, row, plane;
  std::vector<int16_t> laplacian;
  PyramidLevel level;
  Level(int32_t w, int32_t h)
      : grey(static_cast<size_t>(w * h)),
        smoothed(grey.size()),
        row(static_cast<size_t>(w) + 4),
        plane(grey.size()),
        laplacian(grey.size()),
        level{w, h, grey.data(), smoothed.data(), laplacian.data()} {}
  void filter() { filter_level(level, row.data(), plane.data()); }
};

double at(const Plane& in, int32_t w, int32_t h, int32_t x, int32_t y) {
  return in[static_cast<size_t>(std::clamp(y, 0, h - 1) * w + std::clamp(x, 0, w - 1))];
}

Plane smoothed_plainly(const Plane& in, int32_t w, int32_t h) {
  constexpr double kWeights[5] = {1, 4, 6, 4, 1};
  Plane out(in.size());
  for (int32_t y = 0; y < h; ++y) {
    for (int32_t x = 0; x < w; ++x) {
      double sum = 0.0;
      for (int32_t j = 0; j < 5; ++j)
        for (int32_t i = 0; i < 5; ++i) sum += kWeights[i] * kWeights[j] * at(in, w, h, x + i - 2, y + j - 2);
      out[static_cast<size_t>(y * w + x)] = sum / 256.0;
    }
  }
  return out;
}

}  // namespace

TEST_CASE("smoothing and Laplacian are the convolutions, to the rounding") {
  plain::Random random(210);
  for (int scene = 0; scene < 6; ++scene) {
    const int32_t w = random.between(2, 60), h = random.between(2, 50);
    Level level(w, h);
    for (uint16_t& g : level.grey)
      g = static_cast<uint16_t>(random.between(0, scene < 3 ? 65535 : 1) * (scene < 3 ? 1 : 65535));
    level.filter();
    const Plane once = smoothed_plainly(Plane(level.grey.begin(), level.grey.end()), w, h);
    const Plane twice = smoothed_plainly(once, w, h);
    double smooth_error = 0.0, laplacian_error = 0.0;
    for (int32_t y = 0; y < h; ++y) {
      for (int32_t x = 0; x < w; ++x) {
        const auto i = static_cast<size_t>(y * w + x);
        smooth_error = std::max(smooth_error, std::abs(level.smoothed[i] - once[i]));
        double expected = 0.0;
        if (x > 0 && y > 0 && x < w - 1 && y < h - 1) {
          for (int32_t dy = -1; dy <= 1; ++dy) {
            for (int32_t dx = -1; dx <= 1; ++dx)
              expected += (dx == 0 && dy == 0   ? -20.0
                           : dx == 0 || dy == 0 ? 4.0
                                                : 1.0) *
                          at(twice, w, h, x + dx, y + dy);
          }
        }
        laplacian_error = std::max(laplacian_error, std::abs(level.laplacian[i] - expected / 8.0));
      }
    }
    CHECK(smooth_error <= 1.01);
    CHECK(laplacian_error <= 8.0);  // 40 weights of about one unit, over 8
  }
}

TEST_CASE("a coarser level has every other smoothed pixel") {
  plain::Random random(211);
  for (const auto& [w, h] : {std::pair{17, 12}, std::pair{16, 15}}) {
    Level fine(w, h), coarse(halved(w), halved(h));
    for (uint16_t& g : fine.grey) g = static_cast<uint16_t>(random.between(0, 65535));
    fine.filter();
    halve(fine.level, coarse.level);
    for (int32_t y = 0; y < coarse.level.height; ++y) {
      for (int32_t x = 0; x < coarse.level.width; ++x)
        CHECK(coarse.grey[static_cast<size_t>(y * coarse.level.width + x)] ==
              fine.smoothed[static_cast<size_t>(2 * y * w + 2 * x)]);
    }
  }
}
