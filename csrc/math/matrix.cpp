#include "math/matrix.hpp"

#include <algorithm>
#include <cmath>

namespace rvdnav {
namespace math {
namespace {

constexpr int32_t kMaxSweeps = 30;  // of Jacobi's rotations, which converge quadratically: six are usual

ptrdiff_t row(int32_t i, int32_t columns) { return static_cast<ptrdiff_t>(i) * columns; }

// Turns columns p and q of A, n rows, by the rotation with cosine c and sine s.
void turn_columns(double* A, int32_t n, int32_t p, int32_t q, double c, double s) {
  for (int32_t k = 0; k < n; ++k) {
    double* a = A + row(k, n);
    const double at_p = a[p];
    a[p] = c * at_p - s * a[q];
    a[q] = s * at_p + c * a[q];
  }
}

// One rotation that makes A[p][q] zero.
void rotate(double* A, int32_t n, int32_t p, int32_t q, double* V) {
  const double off = A[row(p, n) + q];
  if (off == 0.0) return;
  const double theta = (A[row(q, n) + q] - A[row(p, n) + p]) / (2.0 * off);
  const double t = (theta < 0.0 ? -1.0 : 1.0) / (std::fabs(theta) + std::sqrt(theta * theta + 1.0));
  const double c = 1.0 / std::sqrt(t * t + 1.0);
  const double s = t * c;
  turn_columns(A, n, p, q, c, s);
  double* row_p = A + row(p, n);
  double* row_q = A + row(q, n);
  for (int32_t k = 0; k < n; ++k) {
    const double at_p = row_p[k];
    row_p[k] = c * at_p - s * row_q[k];
    row_q[k] = s * at_p + c * row_q[k];
  }
  turn_columns(V, n, p, q, c, s);
}

}  // namespace

bool cholesky(double* A, int32_t n) {
  for (int32_t j = 0; j < n; ++j) {
    double* u = A + row(j, n);
    if (!(u[j] > 0.0)) return false;
    const double inverse = 1.0 / std::sqrt(u[j]);
    for (int32_t k = j; k < n; ++k) u[k] *= inverse;
    for (int32_t i = j + 1; i < n; ++i) add_multiple(-u[i], u + i, A + row(i, n) + i, n - i);
  }
  return true;
}

void solve_lower(const double* U, int32_t n, double* B, int32_t k) {
  for (int32_t i = 0; i < n; ++i) {
    double* b = B + row(i, k);
    const double inverse = 1.0 / U[row(i, n) + i];
    for (int32_t c = 0; c < k; ++c) b[c] *= inverse;
    for (int32_t r = i + 1; r < n; ++r) add_multiple(-U[row(i, n) + r], b, B + row(r, k), k);
  }
}

void solve_upper(const double* U, int32_t n, double* B, int32_t k) {
  for (int32_t i = n - 1; i >= 0; --i) {
    double* b = B + row(i, k);
    const double inverse = 1.0 / U[row(i, n) + i];
    for (int32_t c = 0; c < k; ++c) b[c] *= inverse;
    for (int32_t r = 0; r < i; ++r) add_multiple(-U[row(r, n) + i], b, B + row(r, k), k);
  }
}

void inverse_lower(const double* U, int32_t n, double* L) {
  std::fill(L, L + row(n, n), 0.0);
  for (int32_t i = 0; i < n; ++i) L[row(i, n) + i] = 1.0;
  for (int32_t i = 0; i < n; ++i) {
    double* l = L + row(i, n);
    const double inverse = 1.0 / U[row(i, n) + i];
    for (int32_t c = 0; c <= i; ++c) l[c] *= inverse;
    for (int32_t r = i + 1; r < n; ++r) add_multiple(-U[row(i, n) + r], l, L + row(r, n), i + 1);
  }
}

void add_square(double factor, const double* B, int32_t n, int32_t k, double* A) {
  for (int32_t i = 0; i < n; ++i) {
    const double* b = B + row(i, k);
    for (int32_t r = 0; r < k; ++r) add_multiple(factor * b[r], b + r, A + row(r, k) + r, k - r);
  }
}

void mirror(double* A, int32_t n) {
  for (int32_t i = 0; i < n; ++i) {
    for (int32_t j = 0; j < i; ++j) A[row(i, n) + j] = A[row(j, n) + i];
  }
}

void eigen_symmetric(double* A, int32_t n, double* eigenvalues, double* V) {
  std::fill(V, V + row(n, n), 0.0);
  for (int32_t i = 0; i < n; ++i) V[row(i, n) + i] = 1.0;
  for (int32_t sweep = 0; sweep < kMaxSweeps; ++sweep) {
    double off = 0.0;
    double diagonal = 0.0;
    for (int32_t p = 0; p < n; ++p) {
      diagonal += A[row(p, n) + p] * A[row(p, n) + p];
      for (int32_t q = p + 1; q < n; ++q) off += A[row(p, n) + q] * A[row(p, n) + q];
    }
    // Below the last digit of the eigenvalues' squares nothing changes any more.
    if (!(off > 1e-36 * diagonal)) break;
    for (int32_t p = 0; p < n; ++p) {
      for (int32_t q = p + 1; q < n; ++q) rotate(A, n, p, q, V);
    }
  }
  for (int32_t i = 0; i < n; ++i) eigenvalues[i] = A[row(i, n) + i];
}

}  // namespace math
}  // namespace rvdnav
