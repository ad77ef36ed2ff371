#include "pose/loss.hpp"

#include <algorithm>

#include "math/order.hpp"
#include "rvdnav/rvdnav.h"

namespace rvdnav {
namespace {

constexpr double kMedianNorm = 1.1774100225154747;  // of a standard normal vector of two components
constexpr double kComponents = 2.0;
constexpr double kMinResponse = 0.4;  // keeps a heavily contaminated set from giving a meaningless factor

}  // namespace

double efficient_k(int32_t kind) { return kind == RVDNAV_LOSS_HUBER ? 1.345 : 4.685; }

double robust_scale(const double* norms, int32_t n, double floor, double* scratch) {
  std::copy(norms, norms + n, scratch);
  return std::max(math::median(scratch, n) / kMedianNorm, floor);
}

void loss_weights(const Loss& loss, const double* norms, int32_t n, double* weights) {
  const double bound = loss.k * loss.scale;
  for (int32_t i = 0; i < n; ++i) {
    const double u = norms[i] / bound;
    const double inside = std::max(1.0 - u * u, 0.0);
    weights[i] = loss.kind == RVDNAV_LOSS_HUBER ? 1.0 / std::max(u, 1.0) : inside * inside;
  }
}

double loss_cost(const Loss& loss, const double* norms, int32_t n) {
  const double bound = loss.k * loss.scale;
  double sum = 0.0;
  for (int32_t i = 0; i < n; ++i) {
    const double u = norms[i] / bound;
    if (loss.kind == RVDNAV_LOSS_HUBER) {
      const double inside = std::min(u, 1.0);
      sum += inside * (u - 0.5 * inside);
    } else {
      const double inside = std::max(1.0 - u * u, 0.0);
      sum += (1.0 - inside * inside * inside) / 6.0;
    }
  }
  return sum * bound * bound;
}

double loss_response(const Loss& loss, const double* norms, int32_t n) {
  const double bound = loss.k * loss.scale;
  double total = 0.0;
  double change = 0.0;  // |r| w'(|r|), what psi' has beyond w in one of a block's two directions
  for (int32_t i = 0; i < n; ++i) {
    const double u = norms[i] / bound;
    if (loss.kind == RVDNAV_LOSS_HUBER) {
      const double w = 1.0 / std::max(u, 1.0);
      total += w;
      change -= u > 1.0 ? w : 0.0;
    } else {
      const double inside = std::max(1.0 - u * u, 0.0);
      total += inside * inside;
      change -= 4.0 * u * u * inside;
    }
  }
  if (!(total > 0.0)) return 0.0;
  return std::min(std::max(1.0 + change / (kComponents * total), kMinResponse), 1.0);
}

}  // namespace rvdnav
