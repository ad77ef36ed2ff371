// Order statistics in bounded time.
#pragma once

#include <stdint.h>

namespace rvdnav {
namespace math {

// Median of n > 0 values, the mean of the two in the middle of an even number; their order is changed.
double median(double* values, int32_t n);

}  // namespace math
}  // namespace rvdnav
