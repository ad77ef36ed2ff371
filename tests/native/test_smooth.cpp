#include <doctest/doctest.h>

#include <algorithm>
#include <vector>

#include "plain.hpp"
#include "rvdnav/rvdnav.h"
#include "smooth.hpp"

using namespace rvdnav;

TEST_CASE("smooth is the 3x3 binomial with replicated borders") {
  plain::Random random(3);
  const Kernels& kernels = *select_kernels(RVDNAV_ISA_AUTO);
  for (const auto& [w, h] : {std::pair{1, 1}, {1, 9}, {9, 1}, {2, 2}, {33, 17}, {64, 5}}) {
    const int32_t stride = w + 3;
    const plain::Grey padded = plain::random_grey(random, stride, h);
    std::vector<uint8_t> out(static_cast<size_t>(w) * static_cast<size_t>(h));
    std::vector<uint16_t> scratch(static_cast<size_t>(w) + 2);
    smooth({padded.pixels.data(), w, h, stride}, kernels, scratch.data(), out.data());
    for (int32_t y = 0; y < h; ++y) {
      for (int32_t x = 0; x < w; ++x) {
        int32_t sum = 8;
        for (int32_t dy = -1; dy <= 1; ++dy)
          for (int32_t dx = -1; dx <= 1; ++dx)
            sum += (2 - std::abs(dx)) * (2 - std::abs(dy)) *
                   padded.at(std::clamp(x + dx, 0, w - 1), std::clamp(y + dy, 0, h - 1));
        REQUIRE(out[static_cast<size_t>(y * w + x)] == sum / 16);
      }
    }
  }
}
