#include "math/order.hpp"

#include <algorithm>

namespace rvdnav {
namespace math {
namespace {

// Of the heap of n values, whose largest is at its root: sinks the value at `root` to where it belongs.
void sink(double* heap, int32_t root, int32_t n) {
  for (int32_t child = 2 * root + 1; child < n; child = 2 * root + 1) {
    if (child + 1 < n && heap[child] < heap[child + 1]) ++child;
    if (!(heap[root] < heap[child])) return;
    std::swap(heap[root], heap[child]);
    root = child;
  }
}

void heap_sort(double* values, int32_t n) {
  for (int32_t root = n / 2 - 1; root >= 0; --root) sink(values, root, n);
  for (int32_t last = n - 1; last > 0; --last) {
    std::swap(values[0], values[last]);
    sink(values, 0, last);
  }
}

double middle_of(double a, double b, double c) { return std::max(std::min(a, b), std::min(std::max(a, b), c)); }

// Puts the value of rank k at place k, smaller ones before it, larger ones after it.  By partition; the few orders that
// make that slow are sorted instead.
void select(double* values, int32_t n, int32_t k) {
  int32_t low = 0;
  int32_t high = n - 1;
  int32_t rounds = 8;
  for (int32_t size = n; size > 1; size /= 2) rounds += 2;
  while (low < high) {
    if (rounds-- == 0) {
      heap_sort(values + low, high - low + 1);
      return;
    }
    const double pivot = middle_of(values[low], values[low + (high - low) / 2], values[high]);
    int32_t i = low;
    int32_t j = high;
    while (i <= j) {
      while (values[i] < pivot) ++i;
      while (pivot < values[j]) --j;
      if (i <= j) std::swap(values[i++], values[j--]);
    }
    if (j < k) low = i;
    if (k < i) high = j;
  }
}

}  // namespace

double median(double* values, int32_t n) {
  const int32_t middle = n / 2;
  select(values, n, middle);
  if (n % 2 == 1) return values[middle];
  return 0.5 * (*std::max_element(values, values + middle) + values[middle]);
}

}  // namespace math
}  // namespace rvdnav
