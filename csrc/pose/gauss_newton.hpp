// Robust Gauss-Newton on a pose and the parameters beside it.
//
// The parameters z have a prior of information U^T U about their mean.  In y = U (z - mean) that is the unit matrix,
// and with Vt = U^-T G^T of the whitened derivative G (m, p) the residuals are r(T) + V y.  With the weights' roots s,
// all parameters are eliminated in the space of the m residuals, by one factor of S = 1 + s V V^T s: however many there
// are, a step costs m^3 and little more.
#pragma once

#include <stdint.h>

#include "arena.hpp"
#include "math/so3.hpp"
#include "pose/displacement.hpp"
#include "pose/line_residuals.hpp"
#include "pose/loss.hpp"

namespace rvdnav {

constexpr int32_t kPoseParameters = 6;

// What the residuals are made of, for n lines and p parameters; m = 2 n.
struct WhitenedLines {
  const rvdnav_pose_cameras* cameras;
  const DirectedLine* lines;  // n
  const double* whitening;    // (n, 2, 2)
  const double* shift;        // (m) of the whitened residuals at the parameters' mean
  const double* Vt;           // (p, m)
  const double* VVt;          // (m, m), its upper triangle
  int32_t n, m, p;
};

// An estimate with its residuals.
struct Estimate {
  math::Transform T;
  double* y;      // (p)
  double* moved;  // (m) V y
  double* r;      // (m) whitened
  double* J;      // (m, 6) whitened
  double* norms;  // (n) of the lines' blocks of r
};

void lay_out(int32_t n, int32_t p, Arena& arena, Estimate* estimate);

// The normal equations of the pose alone, in units that give them a unit diagonal.
struct PoseSystem {
  double units[6];
  double eigenvalues[6];
  double eigenvectors[36];  // columns
};

struct SolverMemory {
  Estimate trial;
  double* weights;  // (n)
  double* roots;    // (m) of the weights
  double* S;        // (m, m) the factor of S
  double* X;        // (m, 8): S^-T s J, then that of the right-hand side, then zeros
  double* scratch;  // (m)
};

constexpr int32_t kColumns = 8;  // of X; a row is a whole number of vectors

void lay_out(int32_t n, int32_t p, Arena& arena, SolverMemory* memory);

struct SolverOptions {
  int32_t loss;       // RVDNAV_LOSS_...
  double k;           // its bound in standard deviations
  bool near_minimum;  // the start is: outliers are told by it at once
};

// How it ended; weights, roots, S and X of the memory are those at the end.
struct Minimum {
  double inverse[36];  // block of the pose in the inverse of the normal matrix
  double response;     // of the loss
  int32_t iterations;
  bool converged;
};

// Sets moved, r, J and norms from T and y.  False if an end is not in front of its camera.
bool evaluate(const WhitenedLines& lines, Estimate* estimate);

// Tukey's loss is not convex, so the start is Huber's loss with the scale taken anew in every step; then the asked loss
// takes over and the scale is held, which makes the cost one function that every accepted step lowers.  A step that
// raises the cost is damped (Levenberg-Marquardt).  Estimate: the start, then the minimum.
rvdnav_status minimise(const WhitenedLines& lines, const SolverOptions& options, Estimate* estimate,
                       SolverMemory* memory, Minimum* minimum);

}  // namespace rvdnav
