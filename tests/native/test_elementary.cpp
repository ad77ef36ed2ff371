#include <doctest/doctest.h>

#include <cmath>
#include <cstdint>
#include <cstring>
#include <limits>
#include <random>

#include "math/elementary.hpp"

namespace math = rvdnav::math;

namespace {

constexpr double kInfinity = std::numeric_limits<double>::infinity();

// How far a value is from the C library's in extended precision, in units of the last place of the nearest double.
double ulps(double value, long double exact) {
  const double nearest = static_cast<double>(exact);
  if (value == nearest) return 0.0;
  const long double unit = std::nextafter(std::abs(nearest), kInfinity) - std::abs(nearest);
  return static_cast<double>(std::abs(value - exact) / unit);
}

// The largest error in many places of [low, high], evenly spread.
template <typename Ours, typename Exact>
double worst(double low, double high, const Ours& ours, const Exact& exact) {
  std::mt19937_64 random(7);
  std::uniform_real_distribution<double> any(low, high);
  double largest = 0.0;
  for (int i = 0; i < 200000; ++i) {
    const double x = any(random);
    largest = std::fmax(largest, ulps(ours(x), exact(static_cast<long double>(x))));
  }
  return largest;
}

bool same(double a, double b) { return std::memcmp(&a, &b, sizeof a) == 0; }

}  // namespace

// The reference needs more digits than a double has.
static_assert(std::numeric_limits<long double>::digits >= 64, "run these tests on x86-64");

TEST_CASE("sine and cosine are within 1 ulp") {
  const auto sine = [](long double x) { return std::sin(x); };
  const auto cosine = [](long double x) { return std::cos(x); };
  for (const double reach : {1e-3, 1.0, 10.0, 16384.0, 1048576.0}) {
    CHECK(worst(-reach, reach, math::sin, sine) <= 1.0);
    CHECK(worst(-reach, reach, math::cos, cosine) <= 1.0);
  }
  // Beside their zeros, where what reduction loses shows.
  for (int k = 1; k < 20000; ++k) {
    const double zero = static_cast<double>(k * 1.57079632679489661923132169163975L);
    CHECK(ulps(math::sin(zero), std::sin(static_cast<long double>(zero))) <= 1.0);
    CHECK(ulps(math::cos(zero), std::cos(static_cast<long double>(zero))) <= 1.0);
  }
  CHECK(same(math::sin(-0.0), -0.0));
  CHECK(math::cos(0.0) == 1.0);
  CHECK(std::isnan(math::sin(2e6)));
  CHECK(std::isnan(math::cos(-kInfinity)));
}

TEST_CASE("arc tangents are within 2 ulp and know their quadrants") {
  const auto exact = [](long double x) { return std::atan(x); };
  for (const double reach : {1e-6, 0.07, 1.0, 10.0, 1e12}) CHECK(worst(-reach, reach, math::atan, exact) <= 2.0);
  CHECK(same(math::atan(kInfinity), std::atan(kInfinity)));
  CHECK(same(math::atan(-0.0), -0.0));
  for (const double y : {-3.0, -1e-12, -0.5}) {
    const auto ours = [y](double x) { return math::atan2(y, x); };
    const auto theirs = [y](long double x) { return std::atan2(static_cast<long double>(y), x); };
    CHECK(worst(-4.0, 4.0, ours, theirs) <= 2.0);
    const auto turned = [y](double x) { return math::atan2(x, y); };
    const auto turned_exact = [y](long double x) { return std::atan2(x, static_cast<long double>(y)); };
    CHECK(worst(-4.0, 4.0, turned, turned_exact) <= 2.0);
  }
  for (const double zero : {-0.0, 0.0}) {
    for (const double other : {-1.0, -0.0, 0.0, 1.0}) {
      CHECK(same(math::atan2(zero, other), std::atan2(zero, other)));
      CHECK(same(math::atan2(other, zero), std::atan2(other, zero)));
    }
  }
}

TEST_CASE("exponential and logarithm are within 1 ulp") {
  const auto exponential = [](long double x) { return std::exp(x); };
  const auto logarithm = [](long double x) { return std::log(x); };
  for (const double reach : {1e-9, 0.4, 10.0, 708.0}) CHECK(worst(-reach, reach, math::exp, exponential) <= 1.0);
  CHECK(worst(-745.0, -708.0, math::exp, exponential) <= 1.0);
  CHECK(worst(709.0, 709.7, math::exp, exponential) <= 1.0);
  for (const double reach : {1e-310, 1e-3, 2.0, 1e9, 1e308}) CHECK(worst(0.0, reach, math::log, logarithm) <= 1.0);
  CHECK(worst(0.999, 1.001, math::log, logarithm) <= 1.0);
  CHECK(math::exp(0.0) == 1.0);
  CHECK(math::exp(710.0) == kInfinity);
  CHECK(math::exp(-kInfinity) == 0.0);
  CHECK(math::log(1.0) == 0.0);
  CHECK(math::log(0.0) == -kInfinity);
  CHECK(std::isnan(math::log(-1.0)));
}

TEST_CASE("the complementary error function is within 4 ulp") {
  const auto exact = [](long double x) { return std::erfc(x); };
  CHECK(worst(-6.0, 0.5, math::erfc, exact) <= 4.0);
  CHECK(worst(0.5, 6.0, math::erfc, exact) <= 4.0);
  CHECK(worst(6.0, 26.5, math::erfc, exact) <= 4.0);
  CHECK(math::erfc(0.0) == 1.0);
  CHECK(math::erfc(kInfinity) == 0.0);
  CHECK(math::erfc(-kInfinity) == 2.0);
}

TEST_CASE("a NaN comes out where one goes in") {
  const double nan = std::numeric_limits<double>::quiet_NaN();
  for (double (*f)(double) : {math::sin, math::cos, math::atan, math::exp, math::log, math::erfc})
    CHECK(std::isnan(f(nan)));
  CHECK(std::isnan(math::atan2(nan, 1.0)));
  CHECK(std::isnan(math::atan2(1.0, nan)));
}
