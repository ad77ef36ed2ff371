#include <doctest/doctest.h>

#include <cmath>
#include <initializer_list>
#include <limits>

#include "math/normal.hpp"

using namespace rvdnav;

TEST_CASE("the table's normal distribution is the C library's within 1e-9") {
  double integral_error = 0.0, density_error = 0.0;
  for (int i = -900000; i <= 900000; ++i) {
    const double z = i * 1e-5 + 3e-6;
    const math::Normal found = math::normal(z);
    integral_error = std::fmax(integral_error, std::abs(found.integral - 0.5 * std::erfc(-z * std::sqrt(0.5))));
    density_error = std::fmax(density_error, std::abs(found.density - std::exp(-0.5 * z * z) / std::sqrt(2.0 * M_PI)));
  }
  CHECK(integral_error < 1e-9);
  CHECK(density_error < 1e-9);
}

TEST_CASE("far out the normal distribution is 0 or 1") {
  const double infinity = std::numeric_limits<double>::infinity();
  for (const double z : {8.0, 30.0, infinity}) {
    CHECK(math::normal(z).integral == 1.0);
    CHECK(math::normal(-z).integral == 0.0);
    CHECK(math::normal(z).density == 0.0);
  }
  CHECK(math::normal(0.0).integral == 0.5);
}
