#include "step_fit.hpp"

#include <algorithm>
#include <cmath>

#include "math/normal.hpp"

namespace rvdnav {
namespace {

constexpr double kStepReach = 1.6;    // the step's own neighbourhood, pixels to both sides
constexpr double kBlurReach = 1.8;    // the same in standard deviations of the blur, if that is more
constexpr double kSlopeReach = 2.5;   // pixels, where the slopes beside it are estimated too
constexpr double kSlopeBlurs = 3.0;   // the same in standard deviations of the blur
constexpr double kFaceMargin = 1.7;   // pixels of a face that the blur of its other side reaches
constexpr double kFaceBlurs = 2.4;    // the same in standard deviations of the blur
constexpr double kOtherSpread = 1.0;  // of the other edge's contrast around the opposite of the step's, as a part of it
constexpr int32_t kIterations = 5;
constexpr double kSettled = 1e-3;  // pixels, of the last change of the step's place
constexpr double kLeastValues = 6.0;
constexpr double kLeastPivot = 1e-9;
constexpr int32_t kWithSlopes = 6, kWithBar = 5;  // parameters of the step between slopes, and with a bar's other edge
constexpr double kMinContrast = 4.0;              // grey levels
constexpr double kMinSignal = 4.0;                // contrast over the residual's standard deviation
constexpr double kTypicalNoise = 2.0;             // grey levels, of one value
constexpr double kMinNoise = 0.7;                 // grey levels: quantisation and read noise
constexpr double kCorrelation = 1.4;   // of neighbouring values, in the standard deviation of the step's place
constexpr double kSigmaSpread = 0.3;   // of the blur from edge to edge, as a fraction
constexpr double kKnownSpread = 0.15;  // the same around a blur that was measured in the image
// The slope on the face that a step bounds, and on what lies behind: shadows, gaps and whatever begins next.
constexpr double kFaceSlope = 0.015;
constexpr double kBackSlope = 0.07;

// Sums of a least-squares problem in so many parameters: the normal equations' matrix, of which the lower triangle
// counts, its right side, the squares of what is fitted, and how much there is of it.
template <int kParameters>
struct Sums {
  double N[kParameters][kParameters] = {};
  double b[kParameters] = {};
  double square = 0.0;
  double count = 0.0;

  void add(const double* J, double value) {
    for (int32_t r = 0; r < kParameters; ++r) {
      for (int32_t c = 0; c <= r; ++c) N[r][c] += J[r] * J[c];
      b[r] += J[r] * value;
    }
    square += value * value;
    count += 1.0;
  }

  // As if parameter k had been measured too.
  void add_prior(int32_t k, double expected, double weight) {
    N[k][k] += weight;
    b[k] += weight * expected;
  }
};

// L D L^T of a symmetric matrix; false where it is not safely positive.
template <int kParameters>
struct Factors {
  double L[kParameters][kParameters];
  double D[kParameters];

  bool of(const double (&N)[kParameters][kParameters]) {
    for (int32_t c = 0; c < kParameters; ++c) {
      D[c] = N[c][c];
      for (int32_t k = 0; k < c; ++k) D[c] -= L[c][k] * L[c][k] * D[k];
      if (!(D[c] > kLeastPivot)) return false;
      const double inverse = 1.0 / D[c];
      for (int32_t r = c + 1; r < kParameters; ++r) {
        double value = N[r][c];
        for (int32_t k = 0; k < c; ++k) value -= L[r][k] * L[c][k] * D[k];
        L[r][c] = value * inverse;
      }
    }
    return true;
  }

  void solve(const double* b, double* x) const {
    for (int32_t r = 0; r < kParameters; ++r) {
      x[r] = b[r];
      for (int32_t k = 0; k < r; ++k) x[r] -= L[r][k] * x[k];
    }
    for (int32_t r = kParameters - 1; r >= 0; --r) {
      x[r] /= D[r];
      for (int32_t k = r + 1; k < kParameters; ++k) x[r] -= L[k][r] * x[k];
    }
  }
};

// The values of a profile that a step at t0 is fitted to.
struct Range {
  int32_t begin, end;
};

Range seen_around(const Profile& profile, double t0, const Surroundings& around) {
  Range range = {0, profile.count};
  while (range.begin < range.end && profile.t[range.begin] - t0 < -around.reach[0]) ++range.begin;
  while (range.begin < range.end && profile.t[range.end - 1] - t0 > around.reach[1]) --range.end;
  return range;
}

// The contrast of a step whose place and blur are given.
bool fit_contrast(const Profile& profile, double t0, double blur, const Surroundings& around, double* contrast) {
  Sums<2> sums;
  const Range range = seen_around(profile, t0, around);
  for (int32_t i = range.begin; i < range.end; ++i) {
    const double J[2] = {1.0, math::normal((profile.t[i] - t0) / blur).integral};
    sums.add(J, profile.grey[i]);
  }
  Factors<2> factors;
  if (sums.count < kLeastValues || !factors.of(sums.N)) return false;
  double solution[2];
  factors.solve(sums.b, solution);
  *contrast = solution[1];
  return true;
}

// What a step and its surroundings are taken to be while they are fitted: fall and rise of the grey beside it, or the
// contrast of a bar's other edge.
struct Estimate {
  double t0, blur, contrast;
  double fall, rise, other;
};

// Parameters: base, contrast, t0, blur, and with slopes fall (towards -t) and rise (towards +t), or with a bar's other
// edge its contrast.  base, contrast and the slopes are linear; they are solved for, and the changes of t0 and blur.
template <int kParameters>
Sums<kParameters> linearised(const Profile& profile, const Surroundings& around, const Estimate& e) {
  Sums<kParameters> sums;
  const double sharpness = 1.0 / e.blur;
  const Range range = seen_around(profile, e.t0, around);
  for (int32_t i = range.begin; i < range.end; ++i) {
    const double x = profile.t[i] - e.t0;
    const double z = x * sharpness;
    const math::Normal step = math::normal(z);
    const double slope = e.contrast * step.density * sharpness;
    double J[kParameters];
    J[0] = 1.0;
    J[1] = step.integral;
    J[2] = -slope;
    J[3] = -slope * z;
    if constexpr (kParameters == kWithBar) {
      const double z2 = (x - around.other) * sharpness;
      const math::Normal far = math::normal(z2);
      const double slope2 = e.other * far.density * sharpness;
      J[2] -= slope2;
      J[3] -= slope2 * z2;
      J[4] = far.integral;
    }
    if constexpr (kParameters == kWithSlopes) {
      const double ramp = x * step.integral + e.blur * step.density;
      J[2] -= e.rise * step.integral + e.fall * (step.integral - 1.0);
      J[3] += (e.rise + e.fall) * step.density;
      J[4] = ramp - x;
      J[5] = ramp;
    }
    sums.add(J, profile.grey[i]);
  }
  return sums;
}

// The blur is held near the expected one, an unknown spread of it being worth as much as elsewhere; slopes near zero,
// and a bar's other edge, which steps back, more or less near the opposite of its first.
template <int kParameters>
void add_priors(const Surroundings& around, double expected_blur, const Estimate& e, Sums<kParameters>* sums) {
  constexpr double kNoise2 = kTypicalNoise * kTypicalNoise;
  const double spread = around.blur_spread * expected_blur;
  sums->add_prior(3, expected_blur - e.blur, kNoise2 / (spread * spread));
  const double contrast = std::max(std::abs(e.contrast), kMinContrast);
  for (int32_t k = 4; k < kParameters; ++k) {
    const bool bar = kParameters == kWithBar;
    const double allowed = (bar ? kOtherSpread : around.slope[k - 4]) * contrast;
    sums->add_prior(k, bar ? -e.contrast : 0.0, kNoise2 / (allowed * allowed));
  }
}

// Gauss-Newton from an estimate whose contrast is known.
template <int kParameters>
bool fit(const Profile& profile, double expected_blur, double half_width, const Surroundings& around, Estimate e,
         Step* step) {
  for (int32_t iteration = 1; iteration <= kIterations; ++iteration) {
    Sums<kParameters> sums = linearised<kParameters>(profile, around, e);
    if (sums.count < kLeastValues) return false;
    add_priors(around, expected_blur, e, &sums);
    Factors<kParameters> factors;
    if (!factors.of(sums.N)) return false;
    double solution[kParameters];
    factors.solve(sums.b, solution);
    e.contrast = solution[1];
    if constexpr (kParameters == kWithSlopes) {
      e.fall = solution[4];
      e.rise = solution[5];
    }
    if constexpr (kParameters == kWithBar) e.other = solution[4];
    const double shift = std::clamp(solution[2], -e.blur, e.blur);
    e.t0 += shift;
    e.blur = std::clamp(e.blur + solution[3], 0.6 * expected_blur, 2.0 * expected_blur);
    if (std::abs(e.t0) > half_width - 1.0) return false;
    if (std::abs(shift) > kSettled && iteration < kIterations) continue;
    double explained = 0.0;
    for (int32_t k = 0; k < kParameters; ++k) explained += solution[k] * sums.b[k];
    const double residual = std::max(sums.square - explained, 0.0) / std::max(sums.count - 4.0, 1.0);
    // Half of the profile's values are interpolated between the same pixels, hence the factor of two.
    const double noise = std::sqrt(2.0 * residual + kMinNoise * kMinNoise);
    const double of_t0[kParameters] = {0.0, 0.0, 1.0};
    double covariance[kParameters];
    factors.solve(of_t0, covariance);
    const double slope = std::abs(e.rise) > std::abs(e.fall) ? e.rise : e.fall;
    *step = {e.t0, e.contrast, e.blur, kCorrelation * noise * std::sqrt(covariance[2]),
             e.contrast == 0.0 ? 0.0 : slope / e.contrast};
    return std::abs(e.contrast) >= std::max(kMinContrast, kMinSignal * noise) && step->sigma < 1.0;
  }
  return false;
}

}  // namespace

Surroundings surroundings(double face, double blur) {
  const double reach = std::max(kStepReach, kBlurReach * blur);
  if (face == 0.0) return {{reach, reach}, {0.0, 0.0}, kSigmaSpread, 0.0};
  const double margin = std::max(kFaceMargin, kFaceBlurs * blur);
  if (std::abs(face) < margin + reach) {
    const double beyond = std::abs(face) + reach;
    if (face > 0.0) return {{reach, beyond}, {0.0, 0.0}, kKnownSpread, face};
    return {{beyond, reach}, {0.0, 0.0}, kKnownSpread, face};
  }
  const double back = std::max(kSlopeReach, kSlopeBlurs * blur);
  const double inside = std::clamp(std::abs(face) - margin, reach, back);
  if (face > 0.0) return {{back, inside}, {kBackSlope, kFaceSlope}, kKnownSpread, 0.0};
  return {{inside, back}, {kFaceSlope, kBackSlope}, kKnownSpread, 0.0};
}

double reach_of(double face, double blur) {
  const Surroundings around = surroundings(face, blur);
  return std::max(around.reach[0], around.reach[1]);
}

// Gauss-Newton for
//   grey = base + contrast Phi(z) + rise (x Phi(z) + blur phi(z)) + fall (x Phi(z) + blur phi(z) - x),
// x = t - t0, z = x / blur, around t0: a blurred step between two slopes.  The blur is a parameter too, held near the
// expected one where the noise hides it: a wrong blur would pull the step towards the side with the more uneven grey.
// So are the slopes, held near zero; without them a shadow along the edge, or a gap behind it, pulls the step its way.
bool fit_step(const Profile& profile, double blur, double half_width, const Surroundings& around, const Step& start,
              Step* step) {
  Estimate e = {start.t0, start.blur, start.contrast, 0.0, 0.0, -start.contrast};
  if (e.contrast == 0.0 && !fit_contrast(profile, e.t0, e.blur, around, &e.contrast)) return false;
  if (around.other != 0.0) return fit<kWithBar>(profile, blur, half_width, around, e, step);
  const bool sloped = around.slope[0] > 0.0 && around.slope[1] > 0.0;
  return sloped ? fit<kWithSlopes>(profile, blur, half_width, around, e, step)
                : fit<4>(profile, blur, half_width, around, e, step);
}

}  // namespace rvdnav
