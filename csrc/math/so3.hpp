// Rotations and rigid transforms: Rodrigues' formula, a pose moved by a small step, the nearest rotation.
// Formulas: J. Sola, J. Deray, D. Atchuthan, "A micro Lie theory for state estimation in robotics" (2018), appendix B.
#pragma once

namespace rvdnav {
namespace math {

// Maps coordinates in the target's frame to those in W.
struct Transform {
  double R[9];  // row-major
  double p[3];
};

inline void multiply_3x3(const double* A, const double* B, double* C) {
  for (int i = 0; i < 3; ++i) {
    for (int j = 0; j < 3; ++j) C[3 * i + j] = A[3 * i] * B[j] + A[3 * i + 1] * B[3 + j] + A[3 * i + 2] * B[6 + j];
  }
}

inline void multiply_3(const double* A, const double* x, double* y) {
  for (int i = 0; i < 3; ++i) y[i] = A[3 * i] * x[0] + A[3 * i + 1] * x[1] + A[3 * i + 2] * x[2];
}

// y = A^T x.
inline void multiply_transposed_3(const double* A, const double* x, double* y) {
  for (int i = 0; i < 3; ++i) y[i] = A[i] * x[0] + A[3 + i] * x[1] + A[6 + i] * x[2];
}

// R (3, 3) of a rotation vector, rad; NaN for one beyond the range of the sine.
void exp_rotation(const double* omega, double* R);

// T moved by delta (6) = (dp, dtheta): p + dp and exp([dtheta]x) R.
Transform perturb(const Transform& T, const double* delta);

// delta (6) with perturb(from, delta) = T.
void difference(const Transform& T, const Transform& from, double* delta);

// R becomes the rotation nearest to it, from one that is nearly so.
void orthonormalise(double* R);

}  // namespace math
}  // namespace rvdnav
