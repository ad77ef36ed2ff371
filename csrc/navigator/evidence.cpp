#include "navigator/evidence.hpp"

#include <algorithm>
#include <cmath>

#include "math/elementary.hpp"
#include "navigator/back_edges.hpp"
#include "navigator/constants.hpp"
#include "status.hpp"

namespace rvdnav {
namespace {

// Part of an edge's samples that must agree in excess for it to have one polarity.
constexpr double kSamePolarity = 0.6;
// Scatter of an edge's samples about its line from which they don't show it.
constexpr double kStraight = 0.7;  // pixels
// Logarithm of the odds for an edge's line against steps that noise put anywhere in the windows: from which the edge is
// shown; the mean of a view's edges from which the view shows the target; and what one edge counts at most in it.
// Neighbouring samples share pixels: two count as one.
constexpr double kLineLogOdds = 4.0;
constexpr double kViewLogOdds = 8.0;
constexpr double kMaxLogOdds = 20.0;
constexpr double kSamplesShared = 2.0;
// Part of the windows in which noise has such a step, and of an edge's, which may be hidden in part.
constexpr double kFoundInNoise = 0.35, kFoundOnEdge = 0.6;
constexpr double kLeastScatter = 0.05;  // pixels
// Of the windows' half-width, where no step is looked for.
constexpr double kWindowMargin = 1.0;  // pixels
constexpr double kTwoPiE = 17.079468445347132;

// Logarithm of the odds for a line.  In noise some step is the steepest in many a window.  Such steps lie evenly within
// the half-width less the margin, those of an edge normally about its line, and in more of the windows.
double log_odds(const rvdnav_edge_line& fit, double used, double attempted, double half_width) {
  const double window = 2.0 * (half_width - kWindowMargin);
  const double scatter = std::max(fit.rms, kLeastScatter);
  const double by_scatter = used * math::log(window / (std::sqrt(kTwoPiE) * scatter));
  const double by_found = used * math::log(kFoundOnEdge / kFoundInNoise);
  const double by_lacking = (attempted - used) * math::log((1.0 - kFoundOnEdge) / (1.0 - kFoundInNoise));
  return (by_scatter + by_found + by_lacking) / kSamplesShared;
}

double odds_of(const Scene& scene, const MeasuredLines& lines, int32_t i, double half_width) {
  const EdgeSamples& samples = lines.samples;
  const int32_t index = scene.index(lines.fits[i].camera, lines.fits[i].edge);
  double used = 0.0;
  for (uint32_t k = samples.begin[index]; k < samples.begin[index + 1]; ++k) used += samples.weights[k] > 0.0 ? 1 : 0;
  return log_odds(lines.fits[i], used, samples.attempted[index], half_width);
}

// Whether each view's edges, taken together, are told from noise.
void told_views(const Scene& scene, const MeasuredLines& lines, double half_width, bool (&told)[RVDNAV_CAMERAS]) {
  double total[RVDNAV_CAMERAS] = {};
  for (int32_t i = 0; i < lines.n; ++i) {
    total[lines.fits[i].camera] += std::clamp(odds_of(scene, lines, i, half_width), 0.0, kMaxLogOdds);
  }
  for (int32_t camera = 0; camera < scene.views; ++camera) {
    const int32_t* attempted = lines.samples.attempted + scene.index(camera, 0);
    const auto looked_at = std::count_if(attempted, attempted + scene.edges, [](int32_t n) { return n > 0; });
    told[camera] = total[camera] / std::max(static_cast<double>(looked_at), 1.0) > kViewLogOdds;
  }
}

void count_agreeing(const EdgeSamples& samples, int32_t index, rvdnav_edge_evidence* evidence) {
  int32_t excess = 0;  // of brighter over darker ones
  for (uint32_t k = samples.begin[index]; k < samples.begin[index + 1]; ++k) {
    if (!(samples.weights[k] > kTrusted)) continue;
    ++evidence->agreed;
    excess += samples.steps[k].polarity;
  }
  if (std::abs(excess) > kSamePolarity * evidence->agreed) evidence->polarity = excess > 0 ? 1 : -1;
}

}  // namespace

rvdnav_status gather_evidence(const Scene& scene, const math::Transform& T, const MeasuredLines& lines,
                              const double* weights, double half_width, const double* blur, MeasuringMemory* memory,
                              rvdnav_edge_evidence* evidence) {
  for (int32_t i = 0; i < scene.size(); ++i) evidence[i] = {lines.samples.attempted[i], 0, 0, 0, blur[i], 0.0};
  bool told[RVDNAV_CAMERAS] = {};
  told_views(scene, lines, half_width, told);
  for (int32_t i = 0; i < lines.n; ++i) {
    const rvdnav_edge_line& fit = lines.fits[i];
    // Between prints any straight line agrees with some profiles; an edge's own don't scatter.
    const bool straight = scene.is_bracket() || fit.rms < kStraight;
    const bool shown = told[fit.camera] && odds_of(scene, lines, i, half_width) > kLineLogOdds;
    if (!(weights[i] > kTrusted) || !straight || !shown) continue;
    const int32_t index = scene.index(fit.camera, fit.edge);
    count_agreeing(lines.samples, index, evidence + index);
  }
  if (scene.is_bracket()) RVDNAV_TRY(add_back_edges(scene, T, memory, evidence));
  return RVDNAV_OK;
}

}  // namespace rvdnav
