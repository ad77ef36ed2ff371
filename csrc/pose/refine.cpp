#include "pose/refine.hpp"

#include <algorithm>
#include <cmath>

#include "math/matrix.hpp"
#include "pose/systematics.hpp"
#include "status.hpp"

namespace rvdnav {
namespace {

constexpr int32_t kMinLines = 3;
// Where the search for the displacement begins, pixels: large, so that edges displaced alike are not taken for outliers
// of a few that agree.
constexpr double kStartSigma = 0.15;
constexpr int32_t kVarianceRounds = 2;
// Where the scale of what the lines share is sought too, that begins as large as it can be and the displacement small:
// what many lines have in common is otherwise taken for a displacement of each, which explains it as well, and stays.
// Both are taken anew at most so often, until none changes by more than this part.
constexpr double kStartBesideShared = 0.05;
constexpr int32_t kMostVarianceRounds = 12;
constexpr double kSettled = 0.05;
// Lines are few and share six parameters with the pose, so their scatter alone would make a scale that is too small.
constexpr double kMinOmegaSquared = 1.0;

// U, mean, Vt, VVt and the residuals' shift, from the whitened derivative; y of the estimate from z.
bool relate_parameters(const rvdnav_pose_problem& problem, const double* scales, int32_t m, int32_t p,
                       RefineMemory* memory) {
  if (!prior_of(problem, scales, memory->U, memory->mean)) return false;
  for (int32_t i = 0; i < m; ++i) {
    const double* g = memory->G + static_cast<ptrdiff_t>(i) * p;
    memory->shift[i] = math::dot(g, memory->mean, p);
    for (int32_t j = 0; j < p; ++j) memory->Vt[static_cast<ptrdiff_t>(j) * m + i] = g[j];
  }
  math::solve_lower(memory->U, p, memory->Vt, m);
  std::fill(memory->VVt, memory->VVt + static_cast<ptrdiff_t>(m) * m, 0.0);
  math::add_square(1.0, memory->Vt, p, m, memory->VVt);
  std::fill(memory->estimate.y, memory->estimate.y + p, 0.0);
  for (int32_t i = 0; i < p; ++i) {
    const double* u = memory->U + static_cast<ptrdiff_t>(i) * p;
    for (int32_t j = i; j < p; ++j) memory->estimate.y[i] += u[j] * (memory->z[j] - memory->mean[j]);
  }
  return true;
}

// The minimum from the estimate's T and z on, at the round's displacement and scales.
rvdnav_status solve(const rvdnav_pose_problem& problem, RefineMemory* memory, WhitenedLines* lines, Refinement* round) {
  const rvdnav_pose_cameras& cameras = problem.cameras;
  if (!known_variances(cameras, problem.lines, memory->lines, lines->n, memory->estimate.T, memory->known)) {
    return RVDNAV_ERROR_BEHIND;
  }
  const int32_t p = lines->p;
  std::copy(problem.derivative, problem.derivative + static_cast<ptrdiff_t>(lines->m) * p, memory->G);
  for (int32_t i = 0; i < lines->n; ++i) {
    double* whitening = memory->whitening + 4 * i;
    double* g = memory->G + 2 * static_cast<ptrdiff_t>(i) * p;
    whitening_of(memory->known[i], round->displacement, whitening);
    whiten(whitening, g, g + p, p);
  }
  if (!relate_parameters(problem, round->scales, lines->m, p, memory)) return RVDNAV_ERROR_UNDETERMINED;
  RVDNAV_TRY(minimise(*lines, round->options, &memory->estimate, &memory->solver, &round->minimum));
  std::copy(memory->estimate.y, memory->estimate.y + p, memory->z);
  math::solve_upper(memory->U, p, memory->z, 1);
  for (int32_t j = 0; j < p; ++j) memory->z[j] += memory->mean[j];
  fill_leverage(*lines, memory->solver, round->minimum, &memory->posterior, memory->leverage);
  return RVDNAV_OK;
}

// Distances (n, 2), pixels, that the estimate leaves.
bool fill_distances(const rvdnav_pose_problem& problem, const WhitenedLines& lines, RefineMemory* memory) {
  double* J = memory->solver.trial.J;  // not needed any more
  if (!line_residuals(problem.cameras, memory->lines, lines.n, memory->estimate.T, memory->distances, J)) return false;
  for (int32_t i = 0; i < lines.m; ++i) {
    memory->distances[i] += math::dot(problem.derivative + static_cast<ptrdiff_t>(i) * lines.p, memory->z, lines.p);
  }
  return true;
}

// Whether a value has changed by no more than the part that is settled.
bool same(double value, double before) { return std::fabs(value - before) <= kSettled * before; }

// The displacement and the groups' scales that the lines show at the minimum, and whether they are settled.
//
// Lens remains, aliasing, light and the model's own errors displace edges by more than their fits know.  The variances
// of offsets and of tilts are those at which the weighted squares of either come to their degrees of freedom, so
// weights and covariance follow the frame (R. C. Paule and J. Mandel, "Consensus values and weighting factors", 1982;
// here for two components, whose degrees of freedom are the lines less the leverage of the parameters on them).
bool learn_from_lines(const rvdnav_pose_problem& problem, const WhitenedLines& lines, RefineMemory* memory,
                      Refinement* round, bool* settled) {
  if (!fill_distances(problem, lines, memory)) return false;
  const Refinement before = *round;
  const math::Transform& T = memory->estimate.T;
  if (!known_variances(problem.cameras, problem.lines, memory->lines, lines.n, T, memory->known)) return false;
  double leverage[2] = {};
  for (int32_t i = 0; i < lines.m; ++i) leverage[i % 2] += memory->leverage[i];
  round->displacement = shown_displacement(memory->known, memory->distances, memory->solver.weights, lines.n, leverage,
                                           memory->solver.scratch);
  if (lines.p > 0) {
    fill_parameters(lines, memory->U, memory->solver, &memory->posterior);
    parameter_variances(lines, round->minimum, memory->posterior, memory->variances);
    rescale(problem, memory->z, memory->variances, round->scales);
  }
  *settled = same(round->displacement.offset, before.displacement.offset) &&
             same(round->displacement.tilt, before.displacement.tilt);
  for (uint32_t g = 0; g < problem.group_count; ++g) *settled = *settled && same(round->scales[g], before.scales[g]);
  return true;
}

// Squared scale of the covariance, omega^2 = sum(w^2 |r|^2) / (c^2 (2 sum(w) - k)) but at least 1, with the loss's
// response c and the k parameters that the lines determine rather than the prior (P. J. Huber and E. M. Ronchetti,
// "Robust Statistics", 2nd ed. (2009), chapter 7); and sigma0, of unit weight.
double unit_weight(const WhitenedLines& lines, const RefineMemory& memory, double response, double* sigma0) {
  double determined = 0.0, total = 0.0, squares = 0.0, twice_weighted = 0.0;
  for (int32_t i = 0; i < lines.m; ++i) determined += memory.leverage[i];
  for (int32_t i = 0; i < lines.n; ++i) {
    const double w = memory.solver.weights[i];
    const double square = memory.estimate.norms[i] * memory.estimate.norms[i];
    total += w;
    squares += w * square;
    twice_weighted += w * w * square;
  }
  const double freedom = std::max(2.0 * total - determined, 1.0);
  *sigma0 = std::sqrt(squares / freedom);
  return std::max(twice_weighted / (response * response * freedom), kMinOmegaSquared);
}

// Where the search begins, and in how many rounds the displacement and the scales are taken anew.
Refinement first_round(const rvdnav_pose_problem& problem, int32_t* rounds) {
  // Ends that move independently of each other move their mean and half their difference alike.
  double sigma = problem.endpoint_sigma / std::sqrt(2.0);
  Refinement round = {};
  bool shared = false;
  for (uint32_t g = 0; g < problem.group_count; ++g) {
    const rvdnav_parameter_group& group = problem.groups[g];
    const bool sought = problem.shown != 0 && group.doubtful != 0 && group.size > 0;
    round.scales[g] = sought ? group.largest : group.scale;
    shared = shared || sought;
  }
  *rounds = 0;
  if (problem.shown != 0) {
    sigma = shared ? kStartBesideShared : kStartSigma;
    *rounds = shared ? kMostVarianceRounds : kVarianceRounds;
  }
  round.displacement = {sigma, sigma};
  round.options = {problem.loss, problem.k > 0.0 ? problem.k : efficient_k(problem.loss), problem.near_minimum != 0};
  return round;
}

WhitenedLines whitened_lines(const rvdnav_pose_problem& problem, const RefineMemory& memory) {
  const int32_t n = static_cast<int32_t>(problem.line_count), p = static_cast<int32_t>(problem.parameter_count);
  return {&problem.cameras, memory.lines, memory.whitening, memory.shift, memory.Vt, memory.VVt, n, 2 * n, p};
}

void copy_out(const double* values, ptrdiff_t count, double* out) {
  if (out != nullptr) std::copy(values, values + count, out);
}

}  // namespace

void lay_out(int32_t n, int32_t p, Arena& arena, RefineMemory* memory) {
  const size_t lines = static_cast<size_t>(n), m = 2 * lines, parameters = static_cast<size_t>(p);
  arena.take(&memory->lines, lines);
  arena.take(&memory->known, lines);
  arena.take(&memory->whitening, 4 * lines);
  for (double** array : {&memory->shift, &memory->distances, &memory->leverage}) arena.take(array, m);
  for (double** array : {&memory->mean, &memory->z, &memory->variances}) arena.take(array, parameters);
  arena.take(&memory->U, parameters * parameters);
  arena.take(&memory->G, m * parameters);
  arena.take(&memory->Vt, m * parameters);
  arena.take(&memory->VVt, m * m);
  lay_out(n, p, arena, &memory->estimate);
  lay_out(n, p, arena, &memory->solver);
  lay_out(n, p, arena, &memory->posterior);
}

rvdnav_status refine_pose(const rvdnav_pose_problem& problem, RefineMemory* memory, Refinement* round) {
  WhitenedLines lines = whitened_lines(problem, *memory);
  if (lines.n < kMinLines) return RVDNAV_ERROR_UNDETERMINED;
  for (int32_t i = 0; i < lines.n; ++i) memory->lines[i] = directed_line(problem.cameras, problem.lines[i]);
  int32_t rounds = 0;
  *round = first_round(problem, &rounds);
  std::copy(problem.R_W_C, problem.R_W_C + 9, memory->estimate.T.R);
  std::copy(problem.p_W, problem.p_W + 3, memory->estimate.T.p);
  if (!prior_of(problem, round->scales, memory->U, memory->mean)) return RVDNAV_ERROR_UNDETERMINED;
  std::copy(memory->mean, memory->mean + lines.p, memory->z);
  bool settled = false;
  for (int32_t i = 0; i < rounds && !settled; ++i) {
    RVDNAV_TRY(solve(problem, memory, &lines, round));
    if (!learn_from_lines(problem, lines, memory, round, &settled)) return RVDNAV_ERROR_BEHIND;
    round->options.near_minimum = true;
  }
  return solve(problem, memory, &lines, round);
}

rvdnav_status report_pose(const rvdnav_pose_problem& problem, const Refinement& round, RefineMemory* memory,
                          rvdnav_refined_pose* result) {
  const WhitenedLines lines = whitened_lines(problem, *memory);
  if (!fill_distances(problem, lines, memory)) return RVDNAV_ERROR_BEHIND;
  const Minimum& minimum = round.minimum;
  const double variance = unit_weight(lines, *memory, minimum.response, &result->sigma0);
  math::Transform T = memory->estimate.T;
  math::orthonormalise(T.R);
  std::copy(T.R, T.R + 9, result->R_W_C);
  std::copy(T.p, T.p + 3, result->p_W);
  for (int32_t i = 0; i < 36; ++i) result->covariance[i] = variance * minimum.inverse[i];
  result->displacement = round.displacement.offset;
  std::copy(round.scales, round.scales + RVDNAV_MAX_GROUPS, result->scales);
  result->iterations = static_cast<uint32_t>(minimum.iterations);
  result->converged = minimum.converged ? 1 : 0;
  copy_out(memory->distances, lines.m, result->residuals);
  copy_out(memory->solver.weights, lines.n, result->weights);
  copy_out(memory->z, lines.p, result->z);
  if (result->gain != nullptr) pose_gain(lines, memory->solver, minimum, memory->posterior, result->gain);
  if (result->joint_covariance != nullptr) {
    fill_parameters(lines, memory->U, memory->solver, &memory->posterior);
    joint_covariance(lines, minimum, memory->posterior, variance, result->joint_covariance);
  }
  if (result->told_information != nullptr) {
    told_by_lines(lines, memory->estimate, memory->G, memory->solver, variance, &memory->posterior,
                  result->told_information, result->told_gradient);
  }
  return RVDNAV_OK;
}

}  // namespace rvdnav
