// Small dense matrices, row-major and without gaps, in one written order of operations: the same bits on every build.
// The inner loops run along rows, so that a compiler can make vector code of them without changing a bit.
#pragma once

#include <stddef.h>
#include <stdint.h>

namespace rvdnav {
namespace math {

// y += a x, n numbers each.  A factor of 0 costs nothing: what is sparse is cheap.
inline void add_multiple(double a, const double* x, double* y, int32_t n) {
  if (a == 0.0) return;
  for (int32_t i = 0; i < n; ++i) y[i] += a * x[i];
}

inline double dot(const double* x, const double* y, int32_t n) {
  double sum = 0.0;
  for (int32_t i = 0; i < n; ++i) sum += x[i] * y[i];
  return sum;
}

// The upper triangle of the symmetric A (n, n) becomes U of A = U^T U; what is below the diagonal is left alone.
// False if A is not positive definite.
bool cholesky(double* A, int32_t n);

// B (n, k) becomes U^-T B.
void solve_lower(const double* U, int32_t n, double* B, int32_t k);

// B (n, k) becomes U^-1 B.
void solve_upper(const double* U, int32_t n, double* B, int32_t k);

// L (n, n) becomes U^-T, zeros above its diagonal.
void inverse_lower(const double* U, int32_t n, double* L);

// The upper triangle of A (k, k) += factor B^T B, of B (n, k).
void add_square(double factor, const double* B, int32_t n, int32_t k, double* A);

// The lower triangle of A (n, n) from the upper one.
void mirror(double* A, int32_t n);

// Eigenvalues and orthonormal eigenvectors, the columns of V (n, n), of the symmetric A (n, n), by Jacobi's rotations
// (G. H. Golub and C. F. Van Loan, "Matrix Computations", 4th ed. (2013), section 8.5).  A is used up.
void eigen_symmetric(double* A, int32_t n, double* eigenvalues, double* V);

}  // namespace math
}  // namespace rvdnav
