#include "profile.hpp"

#include <algorithm>
#include <cmath>

#include <Eigen/LU>

#include "lens.hpp"

namespace rvdnav {
namespace {

constexpr double kSpacing = 0.5;  // pixels between the grey values of a profile
constexpr int32_t kMaxPoints = 2 * 24 + 1;
static_assert(2.0 * kMaxHalfWidth / kSpacing + 1.0 <= kMaxPoints, "profile does not fit");
constexpr double kFitReach = 1.6;  // the step's own neighbourhood, pixels to both sides
constexpr int32_t kIterations = 6;
constexpr double kMinContrast = 4.0;   // grey levels
constexpr double kMinSignal = 4.0;     // contrast over the residual's standard deviation
constexpr double kTypicalNoise = 2.0;  // grey levels, of one value
constexpr double kSigmaSpread = 0.3;   // of the blur from edge to edge, as a fraction
constexpr double kMinNoise = 0.7;      // grey levels: quantisation and read noise
// Linear interpolation widens the step: the variance of its triangle kernel, averaged over the phase, in pixels^2.
constexpr double kInterpolationVariance = 1.0 / 6.0;

struct Profile {
  double t[kMaxPoints];
  double grey[kMaxPoints];
  int32_t count;
};

double interpolate(const GreyView& image, double u, double v) {
  const int32_t x = static_cast<int32_t>(u);
  const int32_t y = static_cast<int32_t>(v);
  const double a = u - x;
  const double b = v - y;
  const uint8_t* p = image.row(y) + x;
  const uint8_t* q = p + image.stride;
  return (1.0 - b) * ((1.0 - a) * p[0] + a * p[1]) + b * ((1.0 - a) * q[0] + a * q[1]);
}

// Grey values across the edge at a rectified point; the lens is taken as straight between the middle and either end.
bool sample_profile(const rvdnav_rig& rig, int32_t camera, const GreyView& image, const Eigen::Vector2d& p,
                    const Eigen::Vector2d& normal, double half_width, Profile* profile) {
  const double offset[3] = {-half_width, 0.0, half_width};
  double u[3];
  double v[3];
  for (int32_t i = 0; i < 3; ++i) {
    const Eigen::Vector2d q = p + offset[i] * normal;
    rect_to_raw(rig, camera, q.x(), q.y(), &u[i], &v[i]);
    // Written so that a NaN fails.
    if (!(u[i] >= 0.0 && v[i] >= 0.0 && u[i] < image.width - 1 && v[i] < image.height - 1)) return false;
  }
  const int32_t half = static_cast<int32_t>(half_width / kSpacing);
  profile->count = 2 * half + 1;
  for (int32_t i = -half; i <= half; ++i) {
    const double t = i * kSpacing;
    const int32_t end = i < 0 ? 0 : 2;
    const double w = std::abs(t) / half_width;
    profile->t[i + half] = t;
    profile->grey[i + half] = interpolate(image, u[1] + w * (u[end] - u[1]), v[1] + w * (v[end] - v[1]));
  }
  return true;
}

// The steepest place of the wanted polarity, preferring the middle; false where the profile is flat.
bool find_start(const Profile& profile, int32_t polarity, double half_width, double* t0) {
  double best = 0.0;
  constexpr int32_t kReach = 2;
  for (int32_t i = kReach; i < profile.count - kReach; ++i) {
    const double slope = profile.grey[i + kReach] - profile.grey[i - kReach];
    if (polarity != 0 && slope * polarity <= 0.0) continue;
    const double x = profile.t[i] / half_width;
    const double score = std::abs(slope) * (1.0 - 0.5 * x * x);
    if (score <= best) continue;
    best = score;
    *t0 = profile.t[i];
  }
  return best >= kMinContrast;
}

struct Step {
  double t0, contrast, sigma;
};

// Gauss-Newton for grey = base + contrast * Phi((t - t0) / sigma) around t0.  The blur is a parameter too, held near
// the expected one where the noise hides it: a wrong blur would pull the step towards the side with the more uneven
// grey.
bool fit_step(const Profile& profile, double expected_sigma, double half_width, double t0, Step* step) {
  constexpr double kInvSqrt2 = 0.70710678118654752;
  constexpr double kInvSqrt2Pi = 0.39894228040143268;
  const double reach = std::max(kFitReach, 1.8 * expected_sigma);
  const double prior = kTypicalNoise * kTypicalNoise / (kSigmaSpread * kSigmaSpread * expected_sigma * expected_sigma);
  double sigma = expected_sigma;
  double contrast = 0.0;
  for (int32_t iteration = 0; iteration < kIterations; ++iteration) {
    // base and contrast are linear: solve for them and the changes of t0 and sigma at once.
    Eigen::Matrix4d N = Eigen::Matrix4d::Zero();
    Eigen::Vector4d b = Eigen::Vector4d::Zero();
    double square = 0.0;
    double n = 0.0;
    for (int32_t i = 0; i < profile.count; ++i) {
      const double x = profile.t[i] - t0;
      if (std::abs(x) > reach) continue;
      const double z = x / sigma;
      const double phi = 0.5 * std::erfc(-z * kInvSqrt2);
      const double slope = contrast * kInvSqrt2Pi * std::exp(-0.5 * z * z) / sigma;
      const Eigen::Vector4d J(1.0, phi, -slope, -slope * z);
      N.noalias() += J * J.transpose();
      b += J * profile.grey[i];
      square += profile.grey[i] * profile.grey[i];
      n += 1.0;
    }
    if (n < 6.0) return false;
    if (iteration == 0) {
      // The contrast is not known yet: t0 and sigma stay.
      N(2, 2) = N(3, 3) = 1.0;
    } else {
      N(3, 3) += prior;
      b(3) += prior * (expected_sigma - sigma);
    }
    Eigen::Matrix4d inverse;
    bool invertible = false;
    N.computeInverseWithCheck(inverse, invertible, 1e-12);
    if (!invertible) return false;
    const Eigen::Vector4d solution = inverse * b;
    contrast = solution(1);
    if (iteration == 0) continue;
    const double shift = std::clamp(solution(2), -sigma, sigma);
    t0 += shift;
    sigma = std::clamp(sigma + solution(3), 0.6 * expected_sigma, 2.0 * expected_sigma);
    if (std::abs(t0) > half_width - 1.0) return false;
    if (std::abs(shift) > 1e-3 && iteration + 1 < kIterations) continue;
    const double residual = std::max(square - solution.dot(b), 0.0) / std::max(n - 4.0, 1.0);
    // Half of the profile's values are interpolated between the same pixels, hence the factor of two.
    const double noise = std::sqrt(2.0 * residual + kMinNoise * kMinNoise);
    step->t0 = t0;
    step->contrast = contrast;
    step->sigma = noise * std::sqrt(inverse(2, 2));
    return std::abs(contrast) >= std::max(kMinContrast, kMinSignal * noise) && step->sigma < 1.0;
  }
  return false;
}

}  // namespace

uint32_t measure_edge(const rvdnav_rig& rig, int32_t camera, const GreyView& image, const rvdnav_model_edge& edge,
                      int32_t edge_index, const ProfileSettings& settings, rvdnav_edge_sample* samples,
                      uint32_t capacity, uint32_t* total) {
  const Eigen::Vector2d start(edge.x0, edge.y0);
  const Eigen::Vector2d span = Eigen::Vector2d(edge.x1, edge.y1) - start;
  const double length = span.norm();
  *total = 0;
  if (!(length > 1e-6)) return 0;
  const Eigen::Vector2d normal(-span.y() / length, span.x() / length);
  const double sigma = std::sqrt(settings.blur_sigma * settings.blur_sigma + kInterpolationVariance);
  const int32_t n = std::max(static_cast<int32_t>(length / settings.step), 1);
  uint32_t count = 0;
  for (int32_t i = 0; i < n; ++i) {
    const double fraction = (i + 0.5) / n;
    const Eigen::Vector2d p = start + fraction * span;
    Profile profile;
    double t0 = 0.0;
    Step step = {};
    if (!sample_profile(rig, camera, image, p, normal, settings.half_width, &profile) ||
        !find_start(profile, edge.polarity, settings.half_width, &t0) ||
        !fit_step(profile, sigma, settings.half_width, t0, &step))
      continue;
    const int32_t polarity = step.contrast > 0.0 ? 1 : -1;
    if (edge.polarity != 0 && polarity != edge.polarity) continue;
    ++*total;
    if (count >= capacity) continue;
    const Eigen::Vector2d q = p + step.t0 * normal;
    samples[count++] = {
        edge_index, polarity, fraction, q.x(), q.y(), normal.x(), normal.y(), step.t0, std::abs(step.contrast),
        step.sigma};
  }
  return count;
}

}  // namespace rvdnav
