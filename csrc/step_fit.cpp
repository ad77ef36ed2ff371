#include "step_fit.hpp"

#include <algorithm>
#include <cmath>

#include <Eigen/Cholesky>
#include <Eigen/Core>

#include "math/elementary.hpp"

namespace rvdnav {
namespace {

constexpr double kStepReach = 1.6;    // the step's own neighbourhood, pixels to both sides
constexpr double kBlurReach = 1.8;    // the same in standard deviations of the blur, if that is more
constexpr double kSlopeReach = 2.5;   // pixels, where the slopes beside it are estimated too
constexpr double kSlopeBlurs = 3.0;   // the same in standard deviations of the blur
constexpr double kFaceMargin = 1.7;   // pixels of a face that the blur of its other side reaches
constexpr double kFaceBlurs = 2.4;    // the same in standard deviations of the blur
constexpr double kOtherSpread = 1.0;  // of the other edge's contrast around the opposite of the step's, as a part of it
constexpr int32_t kIterations = 6;
constexpr double kMinContrast = 4.0;   // grey levels
constexpr double kMinSignal = 4.0;     // contrast over the residual's standard deviation
constexpr double kTypicalNoise = 2.0;  // grey levels, of one value
constexpr double kMinNoise = 0.7;      // grey levels: quantisation and read noise
constexpr double kCorrelation = 1.4;   // of neighbouring values, in the standard deviation of the step's place
constexpr double kSigmaSpread = 0.3;   // of the blur from edge to edge, as a fraction
constexpr double kKnownSpread = 0.15;  // the same around a blur that was measured in the image
// The slope on the face that a step bounds, and on what lies behind: shadows, gaps and whatever begins next.
constexpr double kFaceSlope = 0.015;
constexpr double kBackSlope = 0.07;

// Parameters: base, contrast, t0, blur, and with slopes fall (towards -t) and rise (towards +t), or with a bar's other
// edge its contrast.
template <int kParameters>
bool fit(const Profile& profile, double expected_blur, double half_width, const Surroundings& around, const Step& start,
         Step* step) {
  constexpr bool kSloped = kParameters == 6;
  constexpr bool kBar = kParameters == 5;
  constexpr double kInvSqrt2 = 0.70710678118654752;
  constexpr double kInvSqrt2Pi = 0.39894228040143268;
  constexpr double kNoise2 = kTypicalNoise * kTypicalNoise;
  using Vector = Eigen::Matrix<double, kParameters, 1>;
  using Matrix = Eigen::Matrix<double, kParameters, kParameters>;
  const double spread = around.blur_spread * expected_blur;
  double t0 = start.t0;
  double blur = start.blur;
  double contrast = start.contrast;
  double fall = 0.0;
  double rise = 0.0;
  double other = -contrast;
  for (int32_t iteration = contrast == 0.0 ? 0 : 1; iteration < kIterations; ++iteration) {
    // base, contrast and the slopes are linear: solve for them and the changes of t0 and blur at once.
    Matrix N = Matrix::Zero();
    Vector b = Vector::Zero();
    double square = 0.0;
    double n = 0.0;
    for (int32_t i = 0; i < profile.count; ++i) {
      const double x = profile.t[i] - t0;
      if (x < -around.reach[0] || x > around.reach[1]) continue;
      const double z = x / blur;
      const double phi = 0.5 * math::erfc(-z * kInvSqrt2);
      const double density = kInvSqrt2Pi * math::exp(-0.5 * z * z);
      const double slope = contrast * density / blur;
      Vector J;
      J(0) = 1.0;
      J(1) = phi;
      J(2) = -slope;
      J(3) = -slope * z;
      if constexpr (kBar) {
        const double z2 = (x - around.other) / blur;
        const double slope2 = other * kInvSqrt2Pi * math::exp(-0.5 * z2 * z2) / blur;
        J(2) -= slope2;
        J(3) -= slope2 * z2;
        J(4) = 0.5 * math::erfc(-z2 * kInvSqrt2);
      }
      if constexpr (kSloped) {
        const double ramp = x * phi + blur * density;
        J(2) -= rise * phi + fall * (phi - 1.0);
        J(3) += (rise + fall) * density;
        J(4) = ramp - x;
        J(5) = ramp;
      }
      N.noalias() += J * J.transpose();
      b += J * profile.grey[i];
      square += profile.grey[i] * profile.grey[i];
      n += 1.0;
    }
    if (n < 6.0) return false;
    if (iteration == 0) {
      // The contrast is not known yet: only base and contrast are solved for.
      N.template bottomRows<kParameters - 2>().setZero();
      N.template rightCols<kParameters - 2>().setZero();
      N.diagonal().template tail<kParameters - 2>().setOnes();
      b.template tail<kParameters - 2>().setZero();
    } else if constexpr (kBar) {
      // An unknown spread of the blur is worth as much as elsewhere; the other edge steps back, more or less.
      N(3, 3) += kNoise2 / (spread * spread);
      b(3) += kNoise2 / (spread * spread) * (expected_blur - blur);
      const double allowed = kOtherSpread * std::max(std::abs(contrast), kMinContrast);
      N(4, 4) += kNoise2 / (allowed * allowed);
      b(4) += -contrast * kNoise2 / (allowed * allowed);
    } else {
      N(3, 3) += kNoise2 / (spread * spread);
      b(3) += kNoise2 / (spread * spread) * (expected_blur - blur);
      for (int32_t k = 4; k < kParameters; ++k) {
        const double allowed = around.slope[k - 4] * std::max(std::abs(contrast), kMinContrast);
        N(k, k) += kNoise2 / (allowed * allowed);
      }
    }
    const Eigen::LDLT<Matrix> factors(N);
    if (factors.info() != Eigen::Success || !(factors.vectorD().minCoeff() > 1e-9)) return false;
    const Vector solution = factors.solve(b);
    contrast = solution(1);
    if (iteration == 0) continue;
    if constexpr (kSloped) {
      fall = solution(4);
      rise = solution(5);
    }
    if constexpr (kBar) other = solution(4);
    const double shift = std::clamp(solution(2), -blur, blur);
    t0 += shift;
    blur = std::clamp(blur + solution(3), 0.6 * expected_blur, 2.0 * expected_blur);
    if (std::abs(t0) > half_width - 1.0) return false;
    if (std::abs(shift) > 1e-3 && iteration + 1 < kIterations) continue;
    const double residual = std::max(square - solution.dot(b), 0.0) / std::max(n - 4.0, 1.0);
    // Half of the profile's values are interpolated between the same pixels, hence the factor of two.
    const double noise = std::sqrt(2.0 * residual + kMinNoise * kMinNoise);
    const double variance = factors.solve(Vector::Unit(2))(2);
    const double slope = std::abs(rise) > std::abs(fall) ? rise : fall;
    *step = {t0, contrast, blur, kCorrelation * noise * std::sqrt(variance), contrast == 0.0 ? 0.0 : slope / contrast};
    return std::abs(contrast) >= std::max(kMinContrast, kMinSignal * noise) && step->sigma < 1.0;
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
  if (around.other != 0.0) return fit<5>(profile, blur, half_width, around, start, step);
  const bool sloped = around.slope[0] > 0.0 && around.slope[1] > 0.0;
  return sloped ? fit<6>(profile, blur, half_width, around, start, step)
                : fit<4>(profile, blur, half_width, around, start, step);
}

}  // namespace rvdnav
