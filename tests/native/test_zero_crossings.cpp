#include <doctest/doctest.h>

#include <cmath>
#include <functional>
#include <vector>

#include "correlation.hpp"
#include "plain.hpp"
#include "zero_crossings.hpp"

using namespace rvdnav;

namespace {

struct Found {
  std::vector<Crossing> crossings;
  std::vector<uint32_t> row_start;
  CrossingRows rows() { return {crossings.data(), row_start.data()}; }
};

// Crossings of a picture given in grey levels, everywhere inside but for `margin` columns at each side.
Found crossings_of(int32_t w, int32_t h, const std::function<double(double, double)>& picture, int32_t min_slope,
                   int16_t margin = 0) {
  const auto pixels = static_cast<size_t>(w * h);
  std::vector<uint16_t> grey(pixels), smoothed(pixels), row(static_cast<size_t>(w) + 4), plane(pixels);
  std::vector<int16_t> laplacian(pixels);
  for (int32_t y = 0; y < h; ++y)
    for (int32_t x = 0; x < w; ++x)
      grey[static_cast<size_t>(y * w + x)] = static_cast<uint16_t>(std::lround(256.0 * picture(x, y)));
  const PyramidLevel level = {w, h, grey.data(), smoothed.data(), laplacian.data()};
  filter_level(level, row.data(), plane.data());
  const std::vector<RowSpan> spans(static_cast<size_t>(h), RowSpan{margin, static_cast<int16_t>(w - margin)});
  Found found = {std::vector<Crossing>(static_cast<size_t>(max_crossings(w) * h)),
                 std::vector<uint32_t>(static_cast<size_t>(h) + 1)};
  find_crossings({0, level, spans.data(), h, found.rows()}, min_slope);
  found.crossings.resize(found.row_start.back());
  return found;
}

double step(double distance) { return 0.5 * std::erfc(-distance / (0.7 * std::sqrt(2.0))); }

}  // namespace

TEST_CASE("the crossing of a blurred step lies on it, and knows which side is bright") {
  plain::Random random(220);
  for (int scene = 0; scene < 60; ++scene) {
    const double at = random.real(14.0, 26.0), angle = random.real(-1.2, 1.2), rise = scene % 2 == 0 ? 90.0 : -90.0;
    const double c = std::cos(angle), s = std::sin(angle);
    Found found = crossings_of(
        40, 15, [&](double x, double y) { return 100.0 + rise * (step(c * (x - at) + s * (y - 7.0)) - 0.5); }, 200);
    const uint32_t begin = found.row_start[7];
    REQUIRE(found.row_start[8] - begin == 1);
    const Crossing& crossing = found.crossings[begin];
    CHECK(std::abs(crossing.x_q8 / 256.0 - at) < 0.02);
    CHECK((crossing.slope < 0) == (rise > 0));
    CHECK((crossing.gx > 0) == (rise > 0));
    CHECK(std::atan2(crossing.gy * rise, crossing.gx * rise) == doctest::Approx(angle).epsilon(0.01).scale(10.0));
  }
}

TEST_CASE("a sharp upright step has the slope that the threshold counts on") {
  Found found = crossings_of(
      40, 15, [](double x, double) { return x < 19.5 ? 60.0 : 160.0; }, 100);
  REQUIRE(found.row_start[8] - found.row_start[7] == 1);
  CHECK(std::abs(found.crossings[found.row_start[7]].slope / 100.0 + 19.0) < 3.0);
}

TEST_CASE("flat pictures, edges along the rows and steps below the threshold have no crossings") {
  CHECK(crossings_of(
            40, 15, [](double, double) { return 90.0; }, 100)
            .crossings.empty());
  CHECK(crossings_of(
            40, 15, [](double, double y) { return 100.0 + 90.0 * step(y - 7.3); }, 100)
            .crossings.empty());
  const double nearly = std::atan(1.0 / 12.0);  // twelve columns a row
  CHECK(crossings_of(
            60, 15,
            [&](double x, double y) {
              return 100.0 + 90.0 * step(std::sin(nearly) * (x - 30.0) + std::cos(nearly) * (y - 7.0));
            },
            100)
            .crossings.empty());
  CHECK(crossings_of(
            40, 15, [](double x, double) { return 100.0 + 8.0 * step(x - 19.3); }, 400)
            .crossings.empty());
}

TEST_CASE("what lies outside the spans or in a crowd beyond the limit is left out") {
  const auto picture = [](double x, double) { return 100.0 + 80.0 * (step(x - 9.4) - step(x - 30.2)); };
  CHECK(crossings_of(40, 15, picture, 200).row_start[8] - crossings_of(40, 15, picture, 200).row_start[7] == 2);
  CHECK(crossings_of(40, 15, picture, 200, 7).crossings.empty());
  plain::Random random(221);
  Found crowd = crossings_of(
      60, 9, [&](double, double) { return random.real(0.0, 255.0); }, 0);
  for (size_t y = 0; y < 9; ++y)
    CHECK(crowd.row_start[y + 1] - crowd.row_start[y] <= static_cast<uint32_t>(max_crossings(60)));
}

TEST_CASE("spans shrink to whole pixels of a level") {
  const std::vector<RowSpan> spans = {{3, 60}, {0, 64}, {9, 57}, {1, 8}};
  const auto view = [&](int32_t level) { return LevelView{level, {}, spans.data(), 4, {}}; };
  CHECK(level_span(view(0), 2).begin == 9);
  CHECK(level_span(view(1), 1).begin == 5);
  CHECK(level_span(view(1), 1).end == 29);
  CHECK(level_span(view(2), 1).end == 2);  // beyond the last row: the last one
}

TEST_CASE("integer roots and correlations are those of real numbers") {
  plain::Random random(222);
  for (int i = 0; i < 2000; ++i) {
    const uint64_t v = (uint64_t{random.next()} << 33 ^ uint64_t{random.next()} << 4 ^ random.next()) >> (i % 62);
    const uint64_t root = square_root(v);
    CHECK(root * root <= v);
    CHECK((root == 0xffffffff || (root + 1) * (root + 1) > v));
    const double a = std::exp(random.real(12.0, 36.0)), b = std::exp(random.real(12.0, 36.0)), r = random.real(-1, 1);
    const double cross = r * std::sqrt(a * b);
    const int32_t found =
        correlation_q15(static_cast<int64_t>(cross), static_cast<int64_t>(a), static_cast<int64_t>(b));
    CHECK(std::abs(found / 32768.0 - r) < 5e-4);
  }
  CHECK(correlation_q15(5, 0, 9) == 0);
  CHECK(correlation_q15(1000000, 1000, 1000) == 32768);
}
