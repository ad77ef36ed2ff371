// Robust losses of the refinement.  norms: lengths of whitened blocks of two residuals, the ends of a line, which is
// trusted or rejected as a whole.
// Reference: P. J. Huber and E. M. Ronchetti, "Robust Statistics", 2nd ed. (2009), chapters 4-7.
#pragma once

#include <stdint.h>

namespace rvdnav {

struct Loss {
  int32_t kind;  // RVDNAV_LOSS_...
  double k;      // bound in standard deviations
  double scale;  // of these
};

// The bound that makes a loss 95 % efficient at a normal distribution.
double efficient_k(int32_t kind);

// Scale of n > 0 blocks' noise from their median length, 1 if they are standard normal, at least floor.
double robust_scale(const double* norms, int32_t n, double floor, double* scratch);

// Weights in [0, 1] of iteratively reweighted least squares.
void loss_weights(const Loss& loss, const double* norms, int32_t n, double* weights);

// Sum of the loss over all blocks, in units of squared norm.
double loss_cost(const Loss& loss, const double* norms, int32_t n);

// By how much a weighted mean under this loss answers to a small common shift, as a fraction of its weight, from 0.4 to
// 1: the factor between the weighted normal matrix and the loss's mean curvature.  0 where no block has any weight
// left.
double loss_response(const Loss& loss, const double* norms, int32_t n);

}  // namespace rvdnav
