#include "navigator/measurement.hpp"

#include <algorithm>
#include <cmath>

#include "math/matrix.hpp"
#include "math/order.hpp"
#include "navigator/evidence.hpp"
#include "navigator/surroundings.hpp"
#include "status.hpp"

namespace rvdnav {
namespace {

// Half-width of the profiles at first, around the lines of Hough space, and then around the refined pose.  Each round
// measures where the last one has put the edges, until that changes the pose by less than its standard deviation.
constexpr double kCoarseHalfWidth = 3.5;  // pixels
constexpr double kHalfWidth = 2.5;        // pixels
constexpr int32_t kMaxRounds = 5;
// Shown blur over the expected one from which larger ones are tried; these, pixels; the part of them that must be
// found, where the fit of a sharp step ends at 0.6; and from which on the blur mixes the two edges of a bar, pixels.
constexpr double kBlurred = 1.1;
constexpr double kBlurs[] = {1.3, 2.5, 4.2};
constexpr double kFoundBlur = 0.85;
constexpr double kMixingBlur = 1.2;
// Beside prints the rounds can go to and fro between two sets of samples: from this one on, steps are halved.
constexpr int32_t kFreeRounds = 1;
constexpr double kLeastEndSigma = 0.02;  // pixels; of what displaces an end of a line by itself

// Where the edges are looked for next.
struct Place {
  math::Transform T;
  const double* z;  // (q) the lasting errors that it was found with
};

rvdnav_status look(const Scene& scene, const Place& place, double half_width, const int32_t* polarity,
                   MeasurementMemory* memory) {
  const MeasuringRequest request = {half_width, polarity, memory->face, memory->blur, memory->offsets};
  return measure_lines(scene, place.T, request, &memory->measuring, &memory->lines);
}

// Which of the blurs are larger than wanted and may be larger still: tried becomes 1 there, else 0.
bool suspect(const Scene& scene, const MeasurementMemory& memory) {
  bool any = false;
  for (int32_t i = 0; i < scene.size(); ++i) {
    const bool suspected = memory.blur[i] > kBlurred * scene.blur_sigma;
    memory.tried[i] = suspected ? 1.0 : 0.0;
    any = any || suspected;
  }
  return any;
}

// Looks with a blur expected of the suspected edges; which of them show it stay so, with what they show.
rvdnav_status try_blur(const Scene& scene, const Place& place, double expected, double* found,
                       MeasurementMemory* memory, bool* any) {
  const int32_t size = scene.size();
  std::copy(memory->blur, memory->blur + size, found);
  for (int32_t i = 0; i < size; ++i) {
    if (memory->tried[i] != 0.0) memory->blur[i] = expected;
  }
  RVDNAV_TRY(look(scene, place, kCoarseHalfWidth, scene.problem->polarity, memory));
  update_blur(scene, memory->lines.samples, memory->measuring.scratch, memory->blur);
  *any = false;
  for (int32_t i = 0; i < size; ++i) {
    if (memory->tried[i] != 0.0 && !(memory->blur[i] > kFoundBlur * expected)) memory->tried[i] = 0.0;
    if (memory->tried[i] == 0.0) memory->blur[i] = found[i];
    *any = *any || memory->tried[i] != 0.0;
  }
  return RVDNAV_OK;
}

// The edges around the coarse pose.  The fit of a step looks as far as the expected blur: what is smoothed away farther
// than that seems sharp to it, and a bar narrower than its blur seems to be a wider one.  So a larger one is tried, and
// held to if it is found.
rvdnav_status look_coarsely(const Scene& scene, const Place& place, MeasurementMemory* memory) {
  const int32_t size = scene.size();
  const int32_t* polarity = scene.problem->polarity;
  std::fill(memory->face, memory->face + size, 0.0);
  std::fill(memory->blur, memory->blur + size, scene.blur_sigma);
  RVDNAV_TRY(look(scene, place, kCoarseHalfWidth, polarity, memory));
  update_blur(scene, memory->lines.samples, memory->measuring.scratch, memory->blur);
  bool any = suspect(scene, *memory);
  if (!any) return RVDNAV_OK;
  double* least = memory->least;
  std::copy(memory->blur, memory->blur + size, least);
  if (!face_widths(scene, place.T, memory->face)) return RVDNAV_ERROR_BEHIND;
  for (const double expected : kBlurs) {
    if (any) RVDNAV_TRY(try_blur(scene, place, expected, memory->found, memory, &any));
  }
  const bool larger = !std::equal(memory->blur, memory->blur + size, least, [](double a, double b) { return a <= b; });
  if (!larger) {
    // As at first.
    std::fill(memory->face, memory->face + size, 0.0);
    std::fill(memory->blur, memory->blur + size, scene.blur_sigma);
  }
  RVDNAV_TRY(look(scene, place, kCoarseHalfWidth, polarity, memory));
  update_blur(scene, memory->lines.samples, memory->measuring.scratch, memory->blur);
  return RVDNAV_OK;
}

// The refinement over the lines; shown: with the displacement and scales that they show.
rvdnav_status refine(const Scene& scene, const Place& place, bool shown, MeasurementMemory* memory,
                     rvdnav_pose_problem* problem, Refinement* refinement) {
  const MeasuredLines& lines = memory->lines;
  *problem = {};
  problem->line_count = static_cast<uint32_t>(lines.n);
  problem->lines = lines.lines;
  problem->cameras = scene.problem->cameras;
  std::copy(place.T.R, place.T.R + 9, problem->R_W_C);
  std::copy(place.T.p, place.T.p + 3, problem->p_W);
  problem->loss = RVDNAV_LOSS_TUKEY;
  problem->shown = shown ? 1 : 0;
  problem->endpoint_sigma = kLeastEndSigma;
  for (int32_t i = 0; i < lines.n; ++i) {
    memory->own_blur[i] = memory->blur[scene.index(lines.lines[i].camera, lines.edge[i])];
  }
  const LineCircumstances circumstances = {lines.edge, lines.polarity, memory->own_blur};
  if (!set_systematics(scene, place.T, circumstances, memory->systematics, problem)) return RVDNAV_ERROR_BEHIND;
  return refine_pose(*problem, &memory->refine, refinement);
}

math::Transform pose_of(const rvdnav_refined_pose& pose) {
  math::Transform T;
  std::copy(pose.R_W_C, pose.R_W_C + 9, T.R);
  std::copy(pose.p_W, pose.p_W + 3, T.p);
  return T;
}

// Whether a change (6) is less than a standard deviation.
bool is_short(const double* change, const double* covariance) {
  double U[36], whitened[6];
  std::copy(covariance, covariance + 36, U);
  if (!math::cholesky(U, 6)) return false;
  std::copy(change, change + 6, whitened);
  math::solve_lower(U, 6, whitened, 1);
  return math::dot(whitened, whitened, 6) < 1.0;
}

// The edges around the refined pose, as near as the rounds have come; at first only the blur is known, then the pose is
// near enough to tell the edges' two sides, if the blur doesn't mix them anyway.
rvdnav_status look_closely(const Scene& scene, const Place& place, int32_t round, MeasurementMemory* memory) {
  const int32_t size = scene.size();
  double* scratch = memory->measuring.scratch;
  std::copy(memory->blur, memory->blur + size, scratch);
  const bool sided = round > 0 || math::median(scratch, size) > kMixingBlur;
  std::fill(memory->face, memory->face + size, 0.0);
  if (sided && !face_widths(scene, place.T, memory->face)) return RVDNAV_ERROR_BEHIND;
  if (!lasting_offsets(scene, place.T, place.z, memory->systematics, memory->offsets)) return RVDNAV_ERROR_BEHIND;
  RVDNAV_TRY(look(scene, place, kHalfWidth, memory->either, memory));
  update_blur(scene, memory->lines.samples, scratch, memory->blur);
  return RVDNAV_OK;
}

rvdnav_status finish(const Scene& scene, const Place& place, const rvdnav_pose_problem& problem,
                     const Refinement& refinement, MeasurementMemory* memory, rvdnav_measurement* measurement) {
  RVDNAV_TRY(report_pose(problem, refinement, &memory->refine, &measurement->pose));
  const MeasuredLines& lines = memory->lines;
  measurement->line_count = static_cast<uint32_t>(lines.n);
  std::copy(lines.lines, lines.lines + lines.n, measurement->lines);
  std::copy(lines.edge, lines.edge + lines.n, measurement->line_edges);
  std::copy(problem.derivative, problem.derivative + static_cast<ptrdiff_t>(2) * lines.n * problem.parameter_count,
            measurement->derivative);
  RVDNAV_TRY(gather_evidence(scene, place.T, lines, measurement->pose.weights, kHalfWidth, memory->blur,
                             &memory->measuring, measurement->evidence));
  return learn_from_frame(scene, &memory->learning, measurement) ? RVDNAV_OK : RVDNAV_ERROR_UNDETERMINED;
}

}  // namespace

void lay_out(const rvdnav_measurement_problem& problem, int32_t views, Arena& arena, MeasurementMemory* memory) {
  const ParameterCounts counts = parameter_counts(problem, views);
  const int32_t lines = views * counts.edges;
  const size_t size = static_cast<size_t>(lines);
  lay_out(*problem.model, views, arena, &memory->lines, &memory->measuring);
  lay_out(counts, lines, arena, &memory->systematics);
  lay_out(lines, counts.all(), arena, &memory->refine);
  lay_out(counts, arena, &memory->learning);
  for (double** array :
       {&memory->face, &memory->blur, &memory->least, &memory->found, &memory->tried, &memory->own_blur}) {
    arena.take(array, size);
  }
  arena.take(&memory->offsets, 2 * size);
  arena.take(&memory->either, size);
}

rvdnav_status measure(const Scene& scene, MeasurementMemory* memory, rvdnav_measurement* measurement) {
  const rvdnav_measurement_problem& given = *scene.problem;
  Place place = {{}, given.start};
  std::copy(given.R_W_C, given.R_W_C + 9, place.T.R);
  std::copy(given.p_W, given.p_W + 3, place.T.p);
  std::fill(memory->either, memory->either + scene.size(), 0);
  if (!lasting_offsets(scene, place.T, place.z, memory->systematics, memory->offsets)) return RVDNAV_ERROR_BEHIND;
  RVDNAV_TRY(look_coarsely(scene, place, memory));
  rvdnav_pose_problem problem;
  Refinement refinement;
  RVDNAV_TRY(refine(scene, place, false, memory, &problem, &refinement));
  rvdnav_refined_pose pose = {};
  RVDNAV_TRY(report_pose(problem, refinement, &memory->refine, &pose));
  place = {pose_of(pose), memory->refine.z};
  measurement->settled = 0;
  for (int32_t round = 0; round < kMaxRounds; ++round) {
    RVDNAV_TRY(look_closely(scene, place, round, memory));
    RVDNAV_TRY(refine(scene, place, true, memory, &problem, &refinement));
    RVDNAV_TRY(report_pose(problem, refinement, &memory->refine, &pose));
    double change[6];
    const math::Transform refined = pose_of(pose);
    math::difference(refined, place.T, change);
    place.T = refined;
    measurement->settled = is_short(change, pose.covariance) ? 1 : 0;
    if (measurement->settled != 0 && (round > 0 || !scene.is_bracket())) break;
    if (scene.is_bracket() || round < kFreeRounds) continue;
    for (double& step : change) step *= -0.5;
    place.T = math::perturb(place.T, change);
  }
  return finish(scene, place, problem, refinement, memory, measurement);
}

}  // namespace rvdnav
