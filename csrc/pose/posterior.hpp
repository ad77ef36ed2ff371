// What a minimum tells: covariances of pose and parameters, how much the lines determine, what they tell by themselves.
#pragma once

#include <stdint.h>

#include "arena.hpp"
#include "pose/gauss_newton.hpp"

namespace rvdnav {

struct PosteriorMemory {
  double* L;          // (p, p) U^-T of the prior
  double* K;          // (m, p) S^-T s G (prior covariance)
  double* mixed;      // (p, 6) of the parameters' best values by the pose
  double* S_inverse;  // (m, m) S^-T
  double* Y;          // (m, 8) S^-1 s J
  double* rows;       // (m, 6 + p)
};

void lay_out(int32_t n, int32_t p, Arena& arena, PosteriorMemory* memory);

// At a minimum, with the solver's memory as it left it: S_inverse, Y and the leverage (m) of all parameters on the
// weighted residuals.
void fill_leverage(const WhitenedLines& lines, const SolverMemory& solver, const Minimum& minimum,
                   PosteriorMemory* memory, double* leverage);

// L, K and mixed, with the prior's factor U.
void fill_parameters(const WhitenedLines& lines, const double* U, const SolverMemory& solver, PosteriorMemory* memory);

// Of the parameters (p), from those.
void parameter_variances(const WhitenedLines& lines, const Minimum& minimum, const PosteriorMemory& memory,
                         double* variances);

// (6 + p, 6 + p) of pose and parameters, times a variance of unit weight.
void joint_covariance(const WhitenedLines& lines, const Minimum& minimum, const PosteriorMemory& memory,
                      double variance, double* covariance);

// (6, n, 2): by how much a small change of the residuals, pixels, moves the pose against its sign.
void pose_gain(const WhitenedLines& lines, const SolverMemory& solver, const Minimum& minimum,
               const PosteriorMemory& memory, double* gain);

// Information (6 + p, 6 + p) and gradient (6 + p) at the estimate without any prior; G (m, p) whitened.
void told_by_lines(const WhitenedLines& lines, const Estimate& estimate, const double* G, const SolverMemory& solver,
                   double variance, PosteriorMemory* memory, double* information, double* gradient);

}  // namespace rvdnav
