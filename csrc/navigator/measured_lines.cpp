#include "navigator/measured_lines.hpp"

#include <algorithm>
#include <cmath>

#include "math/elementary.hpp"
#include "navigator/print_borders.hpp"
#include "navigator/shutter.hpp"
#include "navigator/surroundings.hpp"
#include "pose/line_residuals.hpp"
#include "pose/view_pose.hpp"
#include "sampling.hpp"
#include "status.hpp"
#include "target/side_faces.hpp"
#include "target/visibility.hpp"

namespace rvdnav {
namespace {

// How far from the front edge the step may stand where a side face is in sight, as a part of its width in the image; a
// side face brighter than the front draws the step beyond the back edge.
constexpr double kSideSigma = 0.7;
// An edge against an uneven background scatters, and may be displaced as a whole by this part of its scatter; prints
// repeat along an edge, and displace it in many places alike.
constexpr double kUnevenSigma = 0.2;
constexpr double kPrintedSigma = 1.5;
// By which a blur beyond a sharp image's may displace an edge in one view, as a part of it.
constexpr double kBlurSigma = 0.05;
// How far what slopes beside an edge have moved it may be wrong, as a part of it.
constexpr double kMovedSigma = 0.5;

rvdnav_status find_samples(const Scene& scene, const math::Transform& T, const MeasuringRequest& request,
                           MeasuringMemory* memory, EdgeSamples* samples) {
  const size_t count = static_cast<size_t>(scene.size());
  std::copy(request.offsets, request.offsets + 2 * count, memory->offsets);
  if (scene.is_rolling() && !add_shutter_offsets(scene, T, memory->offsets)) return RVDNAV_ERROR_BEHIND;
  const SampleRequest wanted = {request.half_width, request.polarity, request.face, request.blur, memory->offsets, 0.0};
  RVDNAV_TRY(sample_target(scene, T, wanted, samples));
  if (scene.is_rolling() && !refer_to_stamp(scene, T, samples)) return RVDNAV_ERROR_BEHIND;
  std::fill(memory->moved, memory->moved + count, 0.0);
  const bool sided = std::any_of(request.face, request.face + count, [](double width) { return width != 0.0; });
  if (sided) allow_for_slopes(scene, samples, memory->scratch, memory->moved);
  return RVDNAV_OK;
}

// Which side of the lines most of their samples are brighter on.
void fill_polarity(const Scene& scene, MeasuredLines* lines) {
  for (int32_t i = 0; i < lines->n; ++i) {
    const int32_t index = scene.index(lines->fits[i].camera, lines->fits[i].edge);
    double total = 0.0;
    for (uint32_t k = lines->samples.begin[index]; k < lines->samples.begin[index + 1]; ++k) {
      total += lines->samples.weights[k] * lines->samples.steps[k].polarity;
    }
    lines->polarity[i] = total > 0.0 ? 1 : total < 0.0 ? -1 : 0;
  }
}

// How far from each line, pixels, another step may have been taken for its own.
rvdnav_status fill_separation(const Scene& scene, const math::Transform& T, MeasuringMemory* memory,
                              const MeasuredLines& lines) {
  if (scene.is_bracket()) {
    for (int32_t i = 0; i < lines.n; ++i) {
      const rvdnav_edge_line& fit = lines.fits[i];
      const double normal[2] = {math::cos(fit.theta), math::sin(fit.theta)};
      const ViewPose view = view_pose(scene.problem->cameras, fit.camera, T);
      double* separation = memory->separation + scene.index(fit.camera, fit.edge);
      if (!side_separation(scene.model(), view, fit.edge, normal, separation)) return RVDNAV_ERROR_BEHIND;
    }
    return RVDNAV_OK;
  }
  for (int32_t camera = 0; camera < scene.views; ++camera) {
    double* separation = memory->separation + scene.index(camera, 0);
    if (!neighbour_separation(scene.model(), scene.problem->cameras, camera, T, memory->neighbours, separation)) {
      return RVDNAV_ERROR_BEHIND;
    }
  }
  return widen_to_borders(scene, T, lines, memory);
}

double hypot(double a, double b) { return std::sqrt(a * a + b * b); }

}  // namespace

void lay_out(const rvdnav_edge_model& model, int32_t views, Arena& arena, MeasuredLines* lines,
             MeasuringMemory* memory) {
  const size_t edges = static_cast<size_t>(views) * model.edge_count;
  const uint32_t steps = static_cast<uint32_t>(views) * most_pieces(model) * kMostProfiles;
  lay_out(model, views, arena, &lines->samples);
  arena.take(&lines->fits, edges);
  arena.take(&lines->lines, edges);
  arena.take(&lines->edge, edges);
  arena.take(&lines->polarity, edges);
  lay_out(model, views, arena, &memory->beside);
  arena.take(&memory->beside_fits, edges);
  lay_out(steps, arena, &memory->fit);
  arena.take(&memory->neighbours.pieces, most_pieces(model));
  arena.take(&memory->neighbours.edges, model.edge_count);
  arena.take(&memory->neighbours.number, model.edge_count);
  arena.take(&memory->scratch, steps);
  arena.take(&memory->moved, edges);
  arena.take(&memory->separation, edges);
  arena.take(&memory->offsets, 2 * edges);
  arena.take(&memory->opposite, edges);
}

bool end_distances(const Scene& scene, const math::Transform& T, const rvdnav_edge_line& fit, const double* span,
                   double depth, double* distances) {
  rvdnav_pose_line line = {};
  line.camera = fit.camera;
  line.rho = fit.rho;
  line.theta = fit.theta;
  std::copy(span, span + 3, line.from_C);
  std::copy(span + 3, span + 6, line.to_C);
  line.from_C[0] += depth;
  line.to_C[0] += depth;
  double derivatives[12];
  const DirectedLine directed = directed_line(scene.problem->cameras, line);
  return line_residuals(scene.problem->cameras, &directed, 1, T, distances, derivatives);
}

rvdnav_status measure_lines(const Scene& scene, const math::Transform& T, const MeasuringRequest& request,
                            MeasuringMemory* memory, MeasuredLines* lines) {
  EdgeSamples& samples = lines->samples;
  RVDNAV_TRY(find_samples(scene, T, request, memory, &samples));
  uint32_t total = 0;
  lines->n = static_cast<int32_t>(fit_edge_lines(samples.points, samples.count, memory->fit, lines->fits,
                                                 static_cast<uint32_t>(scene.size()), samples.weights, &total));
  fill_polarity(scene, lines);
  RVDNAV_TRY(fill_separation(scene, T, memory, *lines));
  const double uneven = scene.is_bracket() ? kUnevenSigma : kPrintedSigma;
  for (int32_t i = 0; i < lines->n; ++i) {
    const rvdnav_edge_line& fit = lines->fits[i];
    const int32_t index = scene.index(fit.camera, fit.edge);
    const double *from = samples.spans + 6 * index, *cov = fit.covariance;
    const double displaced = hypot(uneven * fit.rms, kMovedSigma * memory->moved[index]);
    const double confused = hypot(kSideSigma * memory->separation[index], displaced);
    const double shift_sigma = hypot(kBlurSigma * blur_excess(request.blur[index]), confused);
    lines->edge[i] = fit.edge;
    lines->lines[i] = {fit.camera, 0,         {from[0], from[1], from[2]},      {from[3], from[4], from[5]},
                       fit.rho,    fit.theta, {cov[0], cov[1], cov[2], cov[3]}, shift_sigma};
  }
  return RVDNAV_OK;
}

}  // namespace rvdnav
