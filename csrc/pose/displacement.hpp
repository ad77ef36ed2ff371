// What displaces lines beyond their covariances: how it whitens their residuals, and how much of it they show.
#pragma once

#include <stdint.h>

#include "pose/line_residuals.hpp"

namespace rvdnav {

// Standard deviations, pixels: offset of a whole line, tilt of its ends in opposite directions.
struct Displacement {
  double offset, tilt;
};

// A matrix (2, 2) that turns a line's two distances into independent ones of unit variance: its offset, and what its
// tilt has beyond what the offset tells of it.
void whitening_of(const OffsetTilt& known, const Displacement& displacement, double* whitening);

// The first and second row of n columns, each of a line's two ends, whitened in place.
inline void whiten(const double* whitening, double* first, double* second, int32_t n) {
  for (int32_t i = 0; i < n; ++i) {
    const double a = first[i], b = second[i];
    first[i] = whitening[0] * a + whitening[1] * b;
    second[i] = whitening[2] * a + whitening[3] * b;
  }
}

// The displacement at which the weighted squares of n lines' offsets and of their tilts equal their degrees of freedom.
// distances (n, 2), pixels; leverage: of all parameters on the offsets and on the tilts; scratch (2 n).
Displacement shown_displacement(const OffsetTilt* known, const double* distances, const double* weights, int32_t n,
                                const double* leverage, double* scratch);

}  // namespace rvdnav
