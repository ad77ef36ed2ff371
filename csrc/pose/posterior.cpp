#include "pose/posterior.hpp"

#include <algorithm>

#include "math/matrix.hpp"

namespace rvdnav {
namespace {

ptrdiff_t row(int32_t i, int32_t columns) { return static_cast<ptrdiff_t>(i) * columns; }

// v^T A v of a symmetric A (6, 6).
double quadratic(const double* A, const double* v) {
  double sum = 0.0;
  for (int32_t i = 0; i < 6; ++i) sum += v[i] * math::dot(A + 6 * i, v, 6);
  return sum;
}

// out (6) = A v of a symmetric A.
void multiply(const double* A, const double* v, double* out) {
  std::fill(out, out + 6, 0.0);
  for (int32_t i = 0; i < 6; ++i) math::add_multiple(v[i], A + 6 * i, out, 6);
}

}  // namespace

void lay_out(int32_t n, int32_t p, Arena& arena, PosteriorMemory* memory) {
  const size_t m = 2 * static_cast<size_t>(n);
  const size_t parameters = static_cast<size_t>(p);
  arena.take(&memory->L, parameters * parameters);
  arena.take(&memory->K, m * parameters);
  arena.take(&memory->mixed, parameters * kPoseParameters);
  arena.take(&memory->S_inverse, m * m);
  arena.take(&memory->Y, m * kColumns);
  arena.take(&memory->rows, m * (kPoseParameters + parameters));
}

void fill_leverage(const WhitenedLines& lines, const SolverMemory& solver, const Minimum& minimum,
                   PosteriorMemory* memory, double* leverage) {
  const int32_t m = lines.m;
  math::inverse_lower(solver.S, m, memory->S_inverse);
  std::copy(solver.X, solver.X + row(m, kColumns), memory->Y);
  math::solve_upper(solver.S, m, memory->Y, kColumns);
  // s (J, G) H^-1 (J, G)^T s = 1 - S^-1 + Y M Y^T with the pose's block M of H^-1.
  std::fill(leverage, leverage + m, 1.0);
  for (int32_t k = 0; k < m; ++k) {
    const double* s = memory->S_inverse + row(k, m);
    for (int32_t i = 0; i <= k; ++i) leverage[i] -= s[i] * s[i];
  }
  for (int32_t i = 0; i < m; ++i) leverage[i] += quadratic(minimum.inverse, memory->Y + row(i, kColumns));
}

void fill_parameters(const WhitenedLines& lines, const double* U, const SolverMemory& solver, PosteriorMemory* memory) {
  const int32_t m = lines.m, p = lines.p;
  math::inverse_lower(U, p, memory->L);
  std::fill(memory->K, memory->K + row(m, p), 0.0);
  for (int32_t i = 0; i < m; ++i) {
    for (int32_t k = 0; k < p; ++k) {
      math::add_multiple(solver.roots[i] * lines.Vt[row(k, m) + i], memory->L + row(k, p), memory->K + row(i, p),
                         k + 1);
    }
  }
  math::solve_lower(solver.S, m, memory->K, p);
  std::fill(memory->mixed, memory->mixed + row(p, kPoseParameters), 0.0);
  for (int32_t i = 0; i < m; ++i) {
    for (int32_t j = 0; j < p; ++j) {
      math::add_multiple(memory->K[row(i, p) + j], solver.X + row(i, kColumns), memory->mixed + row(j, kPoseParameters),
                         kPoseParameters);
    }
  }
}

void parameter_variances(const WhitenedLines& lines, const Minimum& minimum, const PosteriorMemory& memory,
                         double* variances) {
  const int32_t p = lines.p;
  for (int32_t j = 0; j < p; ++j) variances[j] = quadratic(minimum.inverse, memory.mixed + row(j, kPoseParameters));
  for (int32_t k = 0; k < p; ++k) {
    const double* l = memory.L + row(k, p);
    for (int32_t j = 0; j <= k; ++j) variances[j] += l[j] * l[j];
  }
  for (int32_t i = 0; i < lines.m; ++i) {
    const double* k = memory.K + row(i, p);
    for (int32_t j = 0; j < p; ++j) variances[j] -= k[j] * k[j];
  }
}

void joint_covariance(const WhitenedLines& lines, const Minimum& minimum, const PosteriorMemory& memory,
                      double variance, double* covariance) {
  // Of the parameters: of their prior, less what the lines tell, more what they can't tell from the pose.
  const int32_t p = lines.p, size = kPoseParameters + p;
  std::fill(covariance, covariance + row(size, size), 0.0);
  for (int32_t i = 0; i < 6; ++i) {
    for (int32_t j = i; j < 6; ++j) covariance[row(i, size) + j] = minimum.inverse[6 * i + j];
  }
  for (int32_t j = 0; j < p; ++j) {
    double by_pose[6];
    multiply(minimum.inverse, memory.mixed + row(j, kPoseParameters), by_pose);
    for (int32_t i = 0; i < 6; ++i) covariance[row(i, size) + 6 + j] = -by_pose[i];
    double* at = covariance + row(6 + j, size) + 6;
    for (int32_t k = j; k < p; ++k) at[k] = math::dot(by_pose, memory.mixed + row(k, kPoseParameters), 6);
  }
  for (int32_t i = 0; i < p; ++i) {
    const double* l = memory.L + row(i, p);
    for (int32_t j = 0; j <= i; ++j) math::add_multiple(l[j], l + j, covariance + row(6 + j, size) + 6 + j, i + 1 - j);
  }
  for (int32_t i = 0; i < lines.m; ++i) {
    const double* k = memory.K + row(i, p);
    for (int32_t j = 0; j < p; ++j) math::add_multiple(-k[j], k + j, covariance + row(6 + j, size) + 6 + j, p - j);
  }
  for (int32_t i = 0; i < size * size; ++i) covariance[i] *= variance;
  math::mirror(covariance, size);
}

void pose_gain(const WhitenedLines& lines, const SolverMemory& solver, const Minimum& minimum,
               const PosteriorMemory& memory, double* gain) {
  for (int32_t i = 0; i < lines.n; ++i) {
    double by_residual[2][6];
    for (int32_t k = 0; k < 2; ++k) multiply(minimum.inverse, memory.Y + row(2 * i + k, kColumns), by_residual[k]);
    const double* w = lines.whitening + 4 * i;
    for (int32_t c = 0; c < 6; ++c) {
      double* at = gain + 2 * row(c, lines.n) + 2 * i;
      for (int32_t l = 0; l < 2; ++l) {
        at[l] = solver.roots[2 * i] * (by_residual[0][c] * w[l] + by_residual[1][c] * w[2 + l]);
      }
    }
  }
}

void told_by_lines(const WhitenedLines& lines, const Estimate& estimate, const double* G, const SolverMemory& solver,
                   double variance, PosteriorMemory* memory, double* information, double* gradient) {
  const int32_t p = lines.p, size = kPoseParameters + p;
  std::fill(gradient, gradient + size, 0.0);
  std::fill(information, information + row(size, size), 0.0);
  for (int32_t i = 0; i < lines.m; ++i) {
    double* to = memory->rows + row(i, size);
    for (int32_t c = 0; c < 6; ++c) to[c] = solver.roots[i] * estimate.J[6 * i + c];
    for (int32_t j = 0; j < p; ++j) to[6 + j] = solver.roots[i] * G[row(i, p) + j];
    math::add_multiple(solver.roots[i] * estimate.r[i] / variance, to, gradient, size);
  }
  math::add_square(1.0 / variance, memory->rows, lines.m, size, information);
  math::mirror(information, size);
}

}  // namespace rvdnav
