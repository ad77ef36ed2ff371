#include "math/so3.hpp"

#include <cmath>

#include "math/elementary.hpp"

namespace rvdnav {
namespace math {
namespace {

constexpr double kSmallAngle = 1e-4;  // rad; below it two terms of the series are exact to the last digit
constexpr int kPolarRounds = 6;       // each squares the deviation from a rotation

}  // namespace

void exp_rotation(const double* omega, double* R) {
  const double x = omega[0], y = omega[1], z = omega[2];
  const double square = x * x + y * y + z * z;
  const double angle = std::sqrt(square);
  double a = 1.0 - square / 6.0;
  double b = 0.5 - square / 24.0;
  if (!(angle < kSmallAngle)) {
    // 2 sin^2(angle/2) in place of 1 - cos(angle), a difference of near-equal numbers.
    const double half = sin(0.5 * angle) / angle;
    a = sin(angle) / angle;
    b = 2.0 * half * half;
  }
  const double skew[9] = {0.0, -z, y, z, 0.0, -x, -y, x, 0.0};
  double twice[9];
  multiply_3x3(skew, skew, twice);
  for (int i = 0; i < 9; ++i) R[i] = (i % 4 == 0 ? 1.0 : 0.0) + a * skew[i] + b * twice[i];
}

Transform perturb(const Transform& T, const double* delta) {
  double turn[9];
  exp_rotation(delta + 3, turn);
  Transform moved;
  multiply_3x3(turn, T.R, moved.R);
  for (int i = 0; i < 3; ++i) moved.p[i] = T.p[i] + delta[i];
  return moved;
}

void difference(const Transform& T, const Transform& from, double* delta) {
  double turn[9];  // T.R from.R^T
  for (int i = 0; i < 3; ++i) {
    for (int j = 0; j < 3; ++j) {
      const double *a = T.R + 3 * i, *b = from.R + 3 * j;
      turn[3 * i + j] = a[0] * b[0] + a[1] * b[1] + a[2] * b[2];
    }
  }
  const double axis[3] = {0.5 * (turn[7] - turn[5]), 0.5 * (turn[2] - turn[6]), 0.5 * (turn[3] - turn[1])};
  const double sine = std::sqrt(axis[0] * axis[0] + axis[1] * axis[1] + axis[2] * axis[2]);
  const double angle = atan2(sine, 0.5 * (turn[0] + turn[4] + turn[8] - 1.0));
  const double scale = sine > 0.0 ? angle / sine : 1.0;
  for (int i = 0; i < 3; ++i) {
    delta[i] = T.p[i] - from.p[i];
    delta[3 + i] = scale * axis[i];
  }
}

void orthonormalise(double* R) {
  // Newton's iteration for the polar decomposition: the mean of the matrix and its inverse's transpose.
  for (int round = 0; round < kPolarRounds; ++round) {
    double cofactors[9];
    for (int i = 0; i < 3; ++i) {
      const double* a = R + 3 * ((i + 1) % 3);
      const double* b = R + 3 * ((i + 2) % 3);
      for (int j = 0; j < 3; ++j) {
        cofactors[3 * i + j] = a[(j + 1) % 3] * b[(j + 2) % 3] - a[(j + 2) % 3] * b[(j + 1) % 3];
      }
    }
    const double determinant = R[0] * cofactors[0] + R[1] * cofactors[1] + R[2] * cofactors[2];
    for (int i = 0; i < 9; ++i) R[i] = 0.5 * (R[i] + cofactors[i] / determinant);
  }
}

}  // namespace math
}  // namespace rvdnav
