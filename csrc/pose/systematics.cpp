#include "pose/systematics.hpp"

#include <algorithm>
#include <cmath>

#include "math/matrix.hpp"

namespace rvdnav {
namespace {

constexpr double kLeastScale = 0.1;  // below it a group counts as exact

}  // namespace

bool prior_of(const rvdnav_pose_problem& problem, const double* scales, double* U, double* mean) {
  const int32_t p = static_cast<int32_t>(problem.parameter_count);
  std::copy(problem.information, problem.information + static_cast<ptrdiff_t>(p) * p, U);
  ptrdiff_t i = 0;
  for (uint32_t g = 0; g < problem.group_count; ++g) {
    for (uint32_t k = 0; k < problem.groups[g].size; ++k, ++i) U[i * p + i] += 1.0 / (scales[g] * scales[g]);
  }
  if (!math::cholesky(U, p)) return false;
  std::copy(problem.vector, problem.vector + p, mean);
  math::solve_lower(U, p, mean, 1);
  math::solve_upper(U, p, mean, 1);
  return true;
}

void rescale(const rvdnav_pose_problem& problem, const double* z, const double* variances, double* scales) {
  uint32_t i = 0;
  for (uint32_t g = 0; g < problem.group_count; ++g) {
    const rvdnav_parameter_group& group = problem.groups[g];
    double trace = 0.0;
    double square = 0.0;
    for (uint32_t k = 0; k < group.size; ++k, ++i) {
      trace += variances[i];
      square += z[i] * z[i];
    }
    if (!std::isfinite(group.weight)) continue;
    const double determined = group.size - trace / (scales[g] * scales[g]);
    const double ratio = (group.weight + square) / (group.weight + std::max(determined, 0.0));
    scales[g] = std::min(std::max(std::sqrt(ratio), kLeastScale), group.largest);
  }
}

}  // namespace rvdnav
