#include "navigator/print_borders.hpp"

#include <algorithm>
#include <cmath>

#include "status.hpp"

namespace rvdnav {
namespace {

constexpr double kHalfWidth = 3.5;  // pixels
// Of the profiles that must show the step back, and how straight.
constexpr double kCovered = 0.35;
constexpr double kStraight = 0.7;  // pixels
constexpr double kAgreeing = 0.1;  // weight

bool is_shown(const Scene& scene, const rvdnav_edge_line& fit, const EdgeSamples& samples, const int32_t* wanted) {
  const int32_t index = scene.index(fit.camera, fit.edge);
  const double* weights = samples.weights;
  const auto agreed = std::count_if(weights + samples.begin[index], weights + samples.begin[index + 1],
                                    [](double weight) { return weight > kAgreeing; });
  return static_cast<double>(agreed) >= kCovered * samples.attempted[index] && fit.rms < kStraight &&
         wanted[index] != 0;
}

}  // namespace

rvdnav_status widen_to_borders(const Scene& scene, const math::Transform& T, const MeasuredLines& lines,
                               MeasuringMemory* memory) {
  std::fill(memory->opposite, memory->opposite + scene.size(), 0);
  for (int32_t i = 0; i < lines.n; ++i) {
    memory->opposite[scene.index(lines.fits[i].camera, lines.fits[i].edge)] = -lines.polarity[i];
  }
  EdgeSamples& back = memory->beside;
  const SampleRequest request = {kHalfWidth, memory->opposite, nullptr, nullptr, nullptr, 0.0};
  RVDNAV_TRY(sample_target(scene, T, request, &back));
  uint32_t total = 0;
  const uint32_t found = fit_edge_lines(back.points, back.count, memory->fit, memory->beside_fits,
                                        static_cast<uint32_t>(scene.size()), back.weights, &total);
  int32_t own = 0;
  for (uint32_t i = 0; i < found; ++i) {
    const rvdnav_edge_line& fit = memory->beside_fits[i];
    const int32_t index = scene.index(fit.camera, fit.edge);
    // Both lists are in the order of the edges.
    while (own < lines.n && scene.index(lines.fits[own].camera, lines.fits[own].edge) < index) ++own;
    if (own == lines.n || scene.index(lines.fits[own].camera, lines.fits[own].edge) != index) continue;
    if (!is_shown(scene, fit, back, memory->opposite)) continue;
    const double* span = lines.samples.spans + 6 * index;
    double there[2], here[2];
    if (!end_distances(scene, T, fit, span, 0.0, there)) return RVDNAV_ERROR_BEHIND;
    if (!end_distances(scene, T, lines.fits[own], span, 0.0, here)) return RVDNAV_ERROR_BEHIND;
    const double apart = std::fabs(0.5 * (there[0] + there[1]) - 0.5 * (here[0] + here[1]));
    memory->separation[index] = std::max(memory->separation[index], apart);
  }
  return RVDNAV_OK;
}

}  // namespace rvdnav
