#include <doctest/doctest.h>

#include <cmath>
#include <vector>

#include "edge.hpp"
#include "plain.hpp"
#include "rvdnav/rvdnav.h"
#include "smooth.hpp"

using namespace rvdnav;

namespace {

struct Edges {
  plain::BitImage bits;
  std::vector<uint8_t> direction;
};

Edges detect(const plain::Grey& image, const ThresholdCurve& curve) {
  Edges edges{plain::BitImage(image.w, image.h), std::vector<uint8_t>(image.pixels.size())};
  std::fill(edges.bits.words.begin(), edges.bits.words.end(), ~0u);
  std::vector<int16_t> magnitude(3 * edge_scratch_row(static_cast<size_t>(image.w)), 77);
  std::vector<uint8_t> code(magnitude.size(), 77);
  detect_edges(image.pixels.data(), image.w, image.h, curve, *select_kernels(RVDNAV_ISA_AUTO),
               {magnitude.data(), code.data()}, edges.bits.words.data());
  edge_directions(image.pixels.data(), image.w, image.h, *select_kernels(RVDNAV_ISA_AUTO), edges.bits.words.data(),
                  edges.direction.data());
  return edges;
}

plain::Grey smoothed(const plain::Grey& image) {
  plain::Grey out(image.w, image.h);
  std::vector<uint16_t> scratch(static_cast<size_t>(image.w) + 2);
  smooth(image.view(), *select_kernels(RVDNAV_ISA_AUTO), scratch.data(), out.pixels.data());
  return out;
}

// The four kernels written out, and the neighbours along their directions.
constexpr int32_t kSobel[4][3][3] = {{{-1, 0, 1}, {-2, 0, 2}, {-1, 0, 1}},
                                     {{-2, -1, 0}, {-1, 0, 1}, {0, 1, 2}},
                                     {{-1, -2, -1}, {0, 0, 0}, {1, 2, 1}},
                                     {{0, -1, -2}, {1, 0, -1}, {2, 1, 0}}};
constexpr int32_t kAlong[4][2] = {{1, 0}, {1, 1}, {0, 1}, {-1, 1}};

int32_t response(const plain::Grey& image, int32_t x, int32_t y, int k) {
  int32_t sum = 0;
  for (int32_t dy = -1; dy <= 1; ++dy)
    for (int32_t dx = -1; dx <= 1; ++dx) sum += kSobel[k][dy + 1][dx + 1] * image.at(x + dx, y + dy);
  return sum;
}

int32_t magnitude(const plain::Grey& image, int32_t x, int32_t y) {
  int32_t best = 0;
  for (int k = 0; k < 4; ++k) best = std::max(best, std::abs(response(image, x, y, k)));
  return best;
}

double levels_apart(double a, double b) { return std::fabs(std::remainder(a - b, 256.0)); }

}  // namespace

TEST_CASE("the threshold curve: floor in the dark, Weber's law, a quarter of it above the knee") {
  const ThresholdCurve curve = make_threshold_curve(8, 64, 160);  // a quarter of the mean
  CHECK(curve.value[0] == 24);                                    // magnitudes are three times the step
  CHECK(curve.value[32] == 24);
  CHECK(curve.value[100] == 75);
  CHECK(curve.value[160] == 120);
  CHECK(curve.value[224] == 132);
  for (int m = 1; m < 256; ++m) CHECK(curve.value[m] >= curve.value[m - 1]);
}

TEST_CASE("detect_edges equals the definition on random images") {
  plain::Random random(4);
  for (int i = 0; i < 60; ++i) {
    const int32_t w = random.between(5, 110), h = random.between(5, 20);
    // Few levels make many plateaus and ties.
    const plain::Grey image = plain::random_grey(random, w, h, 60, i % 2 == 0 ? 63 : 190);
    const ThresholdCurve curve = make_threshold_curve(1, 20, 100);
    const Edges edges = detect(image, curve);
    for (int32_t y = 0; y < h; ++y) {
      for (int32_t x = 0; x < w; ++x) {
        const bool inner = x >= 2 && y >= 2 && x < w - 2 && y < h - 2;
        if (!inner) {
          REQUIRE(!edges.bits.get(x, y));
          continue;
        }
        const int32_t m = magnitude(image, x, y);
        int k = 0;  // straight directions win ties, then the first
        for (int other : {2, 1, 3})
          if (std::abs(response(image, x, y, other)) > std::abs(response(image, x, y, k))) k = other;
        const int32_t dx = kAlong[k][0], dy = kAlong[k][1];
        int32_t sum = 0;
        for (int32_t v = -1; v <= 1; ++v)
          for (int32_t u = -1; u <= 1; ++u) sum += image.at(x + u, y + v);
        const bool ridge = m > magnitude(image, x - dx, y - dy) && m >= magnitude(image, x + dx, y + dy);
        const bool edge = m > 0 && m >= curve.value[sum / 9] && ridge;
        REQUIRE(edges.bits.get(x, y) == edge);
        const uint8_t direction = edges.direction[image.index(x, y)];
        if (!edge) {
          REQUIRE(direction == 0);
          continue;
        }
        const double gx = response(image, x, y, 0), gy = response(image, x, y, 2);
        if (gx != 0 || gy != 0) REQUIRE(levels_apart(direction, std::atan2(gy, gx) * 128.0 / M_PI) < 1.0);
      }
    }
  }
}

TEST_CASE("a step is an edge from the threshold on, one pixel wide, whatever its direction") {
  const ThresholdCurve curve = make_threshold_curve(8, 0, 255);
  for (int32_t step : {4, 7, 8, 100}) {
    for (bool across : {true, false}) {
      plain::Grey image(40, 40, 20);
      for (int32_t y = 0; y < 40; ++y)
        for (int32_t x = 0; x < 40; ++x)
          if ((across ? x : y) >= 20) image.at(x, y) = static_cast<uint8_t>(20 + step);
      const Edges edges = detect(smoothed(image), curve);
      for (int32_t line = 2; line < 38; ++line) {
        int32_t found = 0;
        for (int32_t i = 0; i < 40; ++i) found += edges.bits.get(across ? i : line, across ? line : i) ? 1 : 0;
        CHECK(found == (step < 8 ? 0 : 1));
      }
    }
  }
}

TEST_CASE("the same relative contrast is seen in dim and in bright light") {
  const ThresholdCurve curve = make_threshold_curve(6, 26, 160);
  for (const auto& [dark, bright] : {std::pair{25, 40}, {30, 70}, {90, 140}, {12, 24}}) {
    plain::Grey image(30, 30, static_cast<uint8_t>(dark));
    for (int32_t y = 0; y < 30; ++y)
      for (int32_t x = 15; x < 30; ++x) image.at(x, y) = static_cast<uint8_t>(bright);
    CHECK(detect(smoothed(image), curve).bits.count() == 26);
  }
  // Ten grey levels are an edge in the dark and nothing on a bright ground.
  plain::Grey image(30, 30, 140);
  for (int32_t y = 0; y < 30; ++y)
    for (int32_t x = 15; x < 30; ++x) image.at(x, y) = 150;
  CHECK(detect(smoothed(image), curve).bits.count() == 0);
}

TEST_CASE("the edges of a bar 5 pixels wide stay apart") {
  plain::Grey image(40, 30, 30);
  for (int32_t y = 0; y < 30; ++y)
    for (int32_t x = 15; x < 20; ++x) image.at(x, y) = 70;
  const Edges edges = detect(smoothed(image), make_threshold_curve(6, 26, 160));
  for (int32_t y = 2; y < 28; ++y) {
    int32_t left = 0, right = 0;
    for (int32_t x = 13; x <= 16; ++x) left += edges.bits.get(x, y) ? 1 : 0;
    for (int32_t x = 18; x <= 21; ++x) right += edges.bits.get(x, y) ? 1 : 0;
    CHECK(left == 1);
    CHECK(right == 1);
    CHECK(!edges.bits.get(17, y));
  }
}

TEST_CASE("the direction points towards brighter along the normal of a blurred step") {
  for (int degrees = 0; degrees < 360; degrees += 7) {
    const double a = degrees * M_PI / 180.0;
    plain::Grey image(60, 60);
    for (int32_t y = 0; y < 60; ++y)
      for (int32_t x = 0; x < 60; ++x) {
        const double d = (x - 29.3) * std::cos(a) + (y - 30.1) * std::sin(a);
        image.at(x, y) = static_cast<uint8_t>(std::lround(40.0 + 120.0 * 0.5 * (1.0 + std::erf(d / 1.1))));
      }
    const Edges edges = detect(smoothed(image), make_threshold_curve(6, 26, 160));
    int32_t count = 0;
    for (int32_t y = 0; y < 60; ++y)
      for (int32_t x = 0; x < 60; ++x) {
        if (!edges.bits.get(x, y)) continue;
        ++count;
        CHECK(levels_apart(edges.direction[image.index(x, y)], degrees * 256.0 / 360.0) < 3.0);
        CHECK(std::fabs((x - 29.3) * std::cos(a) + (y - 30.1) * std::sin(a)) < 1.2);
      }
    CHECK(count >= 50);
  }
}

TEST_CASE("flat and tiny images have no edges") {
  const ThresholdCurve zero = make_threshold_curve(0, 0, 0);
  CHECK(detect(plain::Grey(20, 20, 90), zero).bits.count() == 0);
  for (int32_t n = 1; n < 5; ++n) CHECK(detect(plain::Grey(n, n, 90), zero).bits.count() == 0);
}
