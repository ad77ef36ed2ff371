#include "profile.hpp"

#include <algorithm>
#include <cmath>

#include <Eigen/Core>

#include "lens.hpp"
#include "step_fit.hpp"

namespace rvdnav {
namespace {

constexpr double kMinContrast = 4.0;  // grey levels
// Beyond the half-width a step's surroundings are seen too, where the step's slopes are estimated.
constexpr double kSurround = 1.5;  // pixels
constexpr double kLongestReach = 0.5 * (kMaxProfilePoints - 1) * kProfileSpacing;
static_assert(kMaxHalfWidth + kSurround <= kLongestReach, "profile does not fit");

// How far to both sides the grey values are taken.
double profile_reach(double half_width, double face, double blur) {
  const double needed = reach_of(face, blur);
  const double beyond = face == 0.0 ? needed - reach_of(0.0, 0.0) : std::max(kSurround, needed - 1.0);
  return std::min(half_width + std::max(beyond, 0.0), kLongestReach);
}

// Weights of four neighbouring values at a part a in [0, 1) between the middle two.
void cubic_weights(double a, double* w) {
  const double b = 1.0 - a;
  w[0] = -0.5 * a * b * b;
  w[1] = b * (1.0 + a - 1.5 * a * a);
  w[2] = a * (1.0 + b - 1.5 * b * b);
  w[3] = -0.5 * a * a * b;
}

// Cubic convolution (R. G. Keys, 1981), which keeps the blur of a step, and its place at every phase of the pixels.
double interpolate(const GreyView& image, double u, double v) {
  const int32_t x = static_cast<int32_t>(u);
  const int32_t y = static_cast<int32_t>(v);
  double across[4];
  double down[4];
  cubic_weights(u - x, across);
  cubic_weights(v - y, down);
  const int32_t left = std::max<int32_t>(x - 1, 0);
  const int32_t right = std::min(x + 2, image.width - 1);
  double sum = 0.0;
  for (int32_t k = 0; k < 4; ++k) {
    const uint8_t* row = image.row(std::clamp<int32_t>(y - 1 + k, 0, image.height - 1));
    sum += down[k] * (across[0] * row[left] + across[1] * row[x] + across[2] * row[x + 1] + across[3] * row[right]);
  }
  return sum;
}

// Between the centres of the image's border pixels; a NaN is not.
bool is_on(const GreyView& image, double u, double v) {
  return u >= 0.0 && v >= 0.0 && u < image.width - 1 && v < image.height - 1;
}

// Grey values across the edge at a rectified point whose raw place is given; the lens is taken as straight between the
// middle and either end.
bool sample_profile(const rvdnav_rig& rig, int32_t camera, const GreyView& image, const Eigen::Vector2d& p,
                    const Eigen::Vector2d& raw, const Eigen::Vector2d& normal, double half_width, Profile* profile) {
  double u[3] = {0.0, raw.x(), 0.0};
  double v[3] = {0.0, raw.y(), 0.0};
  for (const int32_t end : {0, 2}) {
    const Eigen::Vector2d q = p + (end - 1) * half_width * normal;
    rect_to_raw(rig, camera, q.x(), q.y(), &u[end], &v[end]);
    if (!is_on(image, u[end], v[end])) return false;
  }
  const int32_t half = static_cast<int32_t>(half_width / kProfileSpacing);
  profile->count = 2 * half + 1;
  for (int32_t i = -half; i <= half; ++i) {
    const double t = i * kProfileSpacing;
    const int32_t end = i < 0 ? 0 : 2;
    const double w = std::abs(t) / half_width;
    profile->t[i + half] = t;
    profile->grey[i + half] = interpolate(image, u[1] + w * (u[end] - u[1]), v[1] + w * (v[end] - v[1]));
  }
  return true;
}

// The steepest place of the wanted polarity, preferring the middle; false where the profile is flat.
bool find_start(const Profile& profile, int32_t polarity, double half_width, double blur, double* t0) {
  double best = 0.0;
  // Values to both sides, between which the slope is taken: over the width of the step, so that noise counts less.
  const int32_t reach = std::clamp<int32_t>(static_cast<int32_t>(blur / kProfileSpacing + 0.5), 2, 8);
  for (int32_t i = reach; i < profile.count - reach; ++i) {
    if (std::abs(profile.t[i]) > half_width - 1.0) continue;
    const double slope = profile.grey[i + reach] - profile.grey[i - reach];
    if (polarity != 0 && slope * polarity <= 0.0) continue;
    const double x = profile.t[i] / half_width;
    const double score = std::abs(slope) * (1.0 - 0.5 * x * x);
    if (score <= best) continue;
    best = score;
    *t0 = profile.t[i];
  }
  return best >= kMinContrast;
}

}  // namespace

ProfileCount measure_edge(const rvdnav_rig& rig, int32_t camera, const GreyView& image, const rvdnav_model_edge& edge,
                          int32_t edge_index, const ProfileSettings& settings, rvdnav_edge_sample* samples,
                          uint32_t capacity) {
  const Eigen::Vector2d start(edge.x0, edge.y0);
  const Eigen::Vector2d span = Eigen::Vector2d(edge.x1, edge.y1) - start;
  const double length = span.norm();
  ProfileCount count = {0, 0};
  if (!(length > 1e-6)) return count;
  const Eigen::Vector2d normal(-span.y() / length, span.x() / length);
  const double blur = edge.blur > 0.0 ? edge.blur : settings.blur_sigma;
  const Surroundings sloped = surroundings(edge.face, blur);
  // The other edge of a bar that the blur reaches is a part of its profile from the start.
  const Surroundings first = sloped.other != 0.0 ? sloped : surroundings(0.0, blur);
  const bool slopes = edge.face != 0.0 && sloped.other == 0.0;
  const double sampled = profile_reach(settings.half_width, edge.face, blur);
  const int32_t n = std::max<int32_t>(static_cast<int32_t>(length / settings.step), 1);
  for (int32_t i = 0; i < n; ++i) {
    const double fraction = (i + 0.5) / n;
    const Eigen::Vector2d p = start + fraction * span;
    Eigen::Vector2d raw;
    rect_to_raw(rig, camera, p.x(), p.y(), &raw.x(), &raw.y());
    if (!is_on(image, raw.x(), raw.y())) continue;
    ++count.on_image;
    Profile profile;
    double t0 = 0.0;
    Step step = {};
    if (!sample_profile(rig, camera, image, p, raw, normal, sampled, &profile) ||
        !find_start(profile, edge.polarity, settings.half_width, blur, &t0) ||
        !fit_step(profile, blur, settings.half_width, first, {t0, 0.0, blur, 0.0, 0.0}, &step))
      continue;
    const int32_t polarity = step.contrast > 0.0 ? 1 : -1;
    if (edge.polarity != 0 && polarity != edge.polarity) continue;
    if (++count.found > capacity) continue;
    Step beside = {};
    const bool known = slopes && fit_step(profile, blur, settings.half_width, sloped, step, &beside) &&
                       beside.contrast * step.contrast > 0.0;
    const Eigen::Vector2d q = p + step.t0 * normal;
    samples[count.found - 1] = {edge_index,
                                polarity,
                                fraction,
                                q.x(),
                                q.y(),
                                normal.x(),
                                normal.y(),
                                step.t0,
                                std::abs(step.contrast),
                                step.sigma,
                                step.blur,
                                known ? beside.t0 - step.t0 : 0.0,
                                known ? beside.slope : 0.0};
  }
  return count;
}

}  // namespace rvdnav
