#include <doctest/doctest.h>

#include <cmath>

#include "angle.hpp"
#include "plain.hpp"

using namespace rvdnav;

namespace {

double levels_off(int32_t x, int32_t y) {
  const double exact = std::atan2(y, x) * 128.0 / M_PI;
  const double off = std::fabs(binary_angle(x, y) - exact);
  return std::fmin(std::fmod(off, 256.0), 256.0 - std::fmod(off, 256.0));
}

}  // namespace

TEST_CASE("binary_angle stays within one level of the arc tangent") {
  double worst = 0.0;
  for (int32_t y = -80; y <= 80; ++y)
    for (int32_t x = -80; x <= 80; ++x)
      if (x != 0 || y != 0) worst = std::fmax(worst, levels_off(x, y));
  plain::Random random(1);
  for (int i = 0; i < 20000; ++i) {
    const int32_t x = random.between(-16777216, 16777216), y = random.between(-16777216, 16777216);
    worst = std::fmax(worst, levels_off(x, y));
  }
  CHECK(worst < 0.7);
}

TEST_CASE("binary_angle on the axes and of nothing") {
  CHECK(binary_angle(5, 0) == 0);
  CHECK(binary_angle(0, 5) == 64);
  CHECK(binary_angle(-5, 0) == 128);
  CHECK(binary_angle(0, -5) == 192);
  CHECK(binary_angle(7, 7) == 32);
  CHECK(binary_angle(0, 0) == 0);
}

TEST_CASE("cos_sin_degrees equals the library's functions") {
  for (int i = -720; i <= 1440; ++i) {
    const CosSin u = cos_sin_degrees(i * 0.5);
    CHECK(u.c == doctest::Approx(std::cos(i * M_PI / 360.0)).epsilon(1e-14));
    CHECK(std::fabs(u.s - std::sin(i * M_PI / 360.0)) < 1e-14);
  }
}

TEST_CASE("divisions round as their names say") {
  for (int32_t v = -300; v <= 300; ++v) {
    CHECK(floor_shift(v, 3) == static_cast<int32_t>(std::floor(v / 8.0)));
    CHECK(round_divide(v, 7) == static_cast<int32_t>(std::round(v / 7.0)));
    CHECK(round_half_away(v / 4.0) == static_cast<int32_t>(std::round(v / 4.0)));
  }
}
