#include <doctest/doctest.h>

#include <cmath>
#include <numeric>
#include <vector>

#include "edgel_lines.hpp"
#include "hough.hpp"

using namespace rvdnav;

namespace {

std::vector<uint16_t> vote(const std::vector<rvdnav_edgel>& edgels, int32_t rho_bins, int32_t spread) {
  std::vector<uint16_t> acc(static_cast<size_t>(kThetaBins * rho_bins), 999);
  hough_vote(edgels.data(), static_cast<uint32_t>(edgels.size()), rho_bins, spread, *select_kernels(RVDNAV_ISA_AUTO),
             acc.data());
  return acc;
}

}  // namespace

TEST_CASE("every direction has the row nearest to its normal") {
  for (int level = 0; level < 256; ++level) {
    const double degrees = level * 360.0 / 256.0;
    const double row = theta_row(static_cast<uint8_t>(level)) - 45.0;
    CHECK(std::fabs(std::remainder(degrees - row, 180.0)) <= 0.5);
  }
}

TEST_CASE("an edgel votes once a row, around its direction, where its line passes") {
  plain::Random random(8);
  for (int32_t rho_bins : {1024, 1023}) {
    for (int i = 0; i < 300; ++i) {
      std::vector<rvdnav_edgel> one;
      plain::add_clutter(one, 1, random);
      const int32_t spread = random.between(0, 45);
      const std::vector<uint16_t> acc = vote(one, rho_bins, spread);
      int32_t rows = 0;
      for (int32_t row = 0; row < kThetaBins; ++row) {
        const auto begin = acc.begin() + row * rho_bins;
        const int32_t votes = std::accumulate(begin, begin + rho_bins, 0);
        const double theta = row - 45.0;
        const double away = std::fabs(std::remainder(one[0].direction * 360.0 / 256.0 - theta, 180.0));
        if (votes == 0) {
          REQUIRE(away > spread - 0.51);
          continue;
        }
        REQUIRE(votes == 1);
        REQUIRE(away < spread + 0.51);
        ++rows;
        const auto cell = std::find(begin, begin + rho_bins, 1) - begin;
        const double rho =
            one[0].x_q5 / 32.0 * std::cos(plain::radians(theta)) + one[0].y_q5 / 32.0 * std::sin(plain::radians(theta));
        // Half a pixel of rounding and the fixed point's own error.
        REQUIRE(std::fabs(static_cast<double>(cell - rho_bins / 2) - rho) < 0.5 + 0.03);
      }
      REQUIRE(rows == 2 * spread + 1);
    }
  }
}

TEST_CASE("votes add up, and those beyond the accumulator are left out") {
  plain::Random random(9);
  std::vector<rvdnav_edgel> edgels;
  plain::add_clutter(edgels, 500, random);
  const std::vector<uint16_t> acc = vote(edgels, 1024, 2);
  CHECK(std::accumulate(acc.begin(), acc.end(), 0) == 500 * 5);
  const std::vector<uint16_t> twice = [&] {
    std::vector<rvdnav_edgel> both = edgels;
    both.insert(both.end(), edgels.begin(), edgels.end());
    return vote(both, 1024, 2);
  }();
  for (size_t i = 0; i < acc.size(); ++i) REQUIRE(twice[i] == 2 * acc[i]);

  // 100 cells: rho from -50.5 to 49.5.
  const auto at = [](int x, uint8_t direction) { return std::vector<rvdnav_edgel>{{x * 32, 0, direction, {}}}; };
  const auto sum = [&](int x, uint8_t direction) {
    const std::vector<uint16_t> small = vote(at(x, direction), 100, 0);
    return std::accumulate(small.begin(), small.end(), 0);
  };
  CHECK(sum(49, 0) == 1);
  CHECK(sum(50, 0) == 0);
  CHECK(sum(-50, 128) == 1);
  CHECK(sum(-51, 128) == 0);
  CHECK(sum(1023, 0) == 0);
  CHECK(sum(-1023, 0) == 0);
}
