#include "math/normal.hpp"

namespace rvdnav {
namespace math {
namespace {

constexpr double kStep = 1.0 / kNormalSteps;
constexpr double kPeak = 0.39894228040143267794;   // 1 / sqrt(2 pi)
constexpr double kFirst = 0.99987793713777441275;  // exp(-kStep^2 / 2)

constexpr NormalTable make_table() {
  NormalTable table = {};
  // exp(-k^2 h^2 / 2) by its ratios, which fall by the same factor from node to node; the integral by the trapezoids
  // with Euler's and Maclaurin's corrections, whose next one is below 1e-15.
  double density = kPeak, ratio = kFirst, sum = 0.0;
  for (int32_t k = 0; k <= kNormalReach * kNormalSteps; ++k) {
    const double z = k * kStep;
    const double trapezoids = kStep * (sum + 0.5 * density - 0.5 * kPeak);
    const double first = -z * density, third = z * (3.0 - z * z) * density;
    const double h2 = kStep * kStep;
    table.nodes[k] = {0.5 + trapezoids - h2 / 12.0 * first + h2 * h2 / 720.0 * third, density};
    sum += density;
    density *= ratio;
    ratio *= kFirst * kFirst;
  }
  return table;
}

}  // namespace

constexpr NormalTable kNormalTable = make_table();

}  // namespace math
}  // namespace rvdnav
