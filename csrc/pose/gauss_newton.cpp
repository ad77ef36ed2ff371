#include "pose/gauss_newton.hpp"

#include <algorithm>
#include <cmath>

#include "math/matrix.hpp"
#include "status.hpp"

namespace rvdnav {
namespace {

// Steps are measured in standard deviations of the estimate.
constexpr double kConvergedStep = 1e-4;
constexpr double kStartStep = 0.3;
constexpr int32_t kStartIterations = 8;
constexpr int32_t kMaxIterations = 20;
constexpr double kDamping[] = {0.0, 1e-3, 1e-2, 1e-1, 1.0, 10.0, 1e2};
// Largest condition number of the pose's normal matrix scaled to unit diagonal.
constexpr double kMaxCondition = 1e8;
// The robust scale is never below this many stated sigmas: so few lines can agree closely by chance.
constexpr double kScaleFloor = 1.0;

// What there is at a set of weights.
struct Step {
  double pose[6];
  double length;  // in standard deviations as stated
};

double* row(double* X, int32_t i) { return X + static_cast<ptrdiff_t>(i) * kColumns; }
const double* row(const double* X, int32_t i) { return X + static_cast<ptrdiff_t>(i) * kColumns; }

// S = 1 + s V V^T s and its factor, X = S^-T s J.
bool eliminate(const WhitenedLines& lines, const Estimate& estimate, SolverMemory* memory) {
  const int32_t m = lines.m;
  for (int32_t i = 0; i < m; ++i) memory->roots[i] = std::sqrt(memory->weights[i / 2]);
  for (int32_t i = 0; i < m; ++i) {
    const ptrdiff_t begin = static_cast<ptrdiff_t>(i) * m;
    for (int32_t j = i; j < m; ++j) memory->S[begin + j] = memory->roots[i] * memory->roots[j] * lines.VVt[begin + j];
    memory->S[begin + i] += 1.0;
    double* x = row(memory->X, i);
    for (int32_t c = 0; c < 6; ++c) x[c] = memory->roots[i] * estimate.J[6 * i + c];
  }
  return math::cholesky(memory->S, m);
}

// The pose's own system from X; false if it is singular or nearly so.
bool reduce(const double* X, int32_t m, PoseSystem* system) {
  double normal[36] = {};
  for (int32_t i = 0; i < m; ++i) {
    const double* x = row(X, i);
    for (int32_t r = 0; r < 6; ++r) math::add_multiple(x[r], x, normal + 6 * r, 6);
  }
  for (int32_t i = 0; i < 6; ++i) {
    if (!(normal[7 * i] > 0.0)) return false;
    system->units[i] = 1.0 / std::sqrt(normal[7 * i]);
  }
  for (int32_t i = 0; i < 36; ++i) normal[i] *= system->units[i / 6] * system->units[i % 6];
  math::eigen_symmetric(normal, 6, system->eigenvalues, system->eigenvectors);
  const double least = *std::min_element(system->eigenvalues, system->eigenvalues + 6);
  const double largest = *std::max_element(system->eigenvalues, system->eigenvalues + 6);
  return least * kMaxCondition > largest;
}

// Weights, factor and pose system at an estimate.
rvdnav_status linearise(const WhitenedLines& lines, const Loss& loss, const Estimate& estimate, SolverMemory* memory,
                        double* response, PoseSystem* system) {
  loss_weights(loss, estimate.norms, lines.n, memory->weights);
  *response = loss_response(loss, estimate.norms, lines.n);
  if (!(*response > 0.0)) return RVDNAV_ERROR_NO_AGREEMENT;
  if (!eliminate(lines, estimate, memory)) return RVDNAV_ERROR_UNDETERMINED;
  // The loss curves less than its weights say; without its response the steps are too short and convergence is slow.
  for (int32_t i = 0; i < lines.m; ++i) {
    double* x = row(memory->X, i);
    x[6] = memory->roots[i] * (estimate.r[i] / *response - estimate.moved[i]);
    x[7] = 0.0;
  }
  math::solve_lower(memory->S, lines.m, memory->X, kColumns);
  return reduce(memory->X, lines.m, system) ? RVDNAV_OK : RVDNAV_ERROR_UNDETERMINED;
}

// The pose's step, its directions damped.
void solve_pose(const PoseSystem& system, const double* X, int32_t m, double damping, double* step) {
  double right[6] = {};
  for (int32_t i = 0; i < m; ++i) math::add_multiple(row(X, i)[6], row(X, i), right, 6);
  double along[6] = {};
  for (int32_t i = 0; i < 6; ++i) math::add_multiple(system.units[i] * right[i], system.eigenvectors + 6 * i, along, 6);
  for (int32_t i = 0; i < 6; ++i) along[i] /= system.eigenvalues[i] + damping;
  for (int32_t i = 0; i < 6; ++i) step[i] = -system.units[i] * math::dot(system.eigenvectors + 6 * i, along, 6);
}

// The parameters that go with a step of the pose, y = -V^T s S^-1 (right-hand side + s J step).
void solve_parameters(const WhitenedLines& lines, const double* step, const SolverMemory& memory, double* y) {
  double* t = memory.scratch;
  for (int32_t i = 0; i < lines.m; ++i) t[i] = row(memory.X, i)[6] + math::dot(row(memory.X, i), step, 6);
  math::solve_upper(memory.S, lines.m, t, 1);
  for (int32_t i = 0; i < lines.m; ++i) t[i] *= memory.roots[i];
  for (int32_t j = 0; j < lines.p; ++j) y[j] = -math::dot(lines.Vt + static_cast<ptrdiff_t>(j) * lines.m, t, lines.m);
}

// The trial estimate, moved from one by the step at some damping; false if it is not in front of the cameras.
bool take_step(const WhitenedLines& lines, const PoseSystem& system, const Estimate& from, double damping,
               SolverMemory* memory, Step* step) {
  Estimate& trial = memory->trial;
  solve_pose(system, memory->X, lines.m, damping, step->pose);
  solve_parameters(lines, step->pose, *memory, trial.y);
  trial.T = math::perturb(from.T, step->pose);
  const bool in_front = evaluate(lines, &trial);
  double square = 0.0;
  for (int32_t i = 0; i < lines.m; ++i) {
    const double change = math::dot(from.J + 6 * i, step->pose, 6) + (trial.moved[i] - from.moved[i]);
    square += memory->weights[i / 2] * change * change;
  }
  for (int32_t j = 0; j < lines.p; ++j) square += (trial.y[j] - from.y[j]) * (trial.y[j] - from.y[j]);
  step->length = std::sqrt(square);
  return in_front;
}

double total_cost(const Loss& loss, const Estimate& estimate, const WhitenedLines& lines) {
  return loss_cost(loss, estimate.norms, lines.n) + 0.5 * math::dot(estimate.y, estimate.y, lines.p);
}

// Moves the estimate by the first step that is short or doesn't raise the cost; false if there is none.
bool improve(const WhitenedLines& lines, const Loss& loss, const PoseSystem& system, SolverMemory* memory,
             Estimate* estimate, double* length) {
  const double before = total_cost(loss, *estimate, lines);
  for (const double damping : kDamping) {
    Step step;
    if (!take_step(lines, system, *estimate, damping, memory, &step)) continue;
    *length = step.length / loss.scale;
    // A step this short is at the rounding of the cost, where comparing costs says nothing.
    if (*length < kConvergedStep || total_cost(loss, memory->trial, lines) <= before) {
      std::swap(*estimate, memory->trial);
      return true;
    }
  }
  return false;
}

void invert(const PoseSystem& system, double* inverse) {
  double roots[36];  // of the inverse: rows belong to eigenvectors
  for (int32_t i = 0; i < 36; ++i) {
    roots[i] = system.units[i % 6] * system.eigenvectors[6 * (i % 6) + i / 6] / std::sqrt(system.eigenvalues[i / 6]);
  }
  std::fill(inverse, inverse + 36, 0.0);
  math::add_square(1.0, roots, 6, 6, inverse);
  math::mirror(inverse, 6);
}

}  // namespace

void lay_out(int32_t n, int32_t p, Arena& arena, Estimate* estimate) {
  const size_t lines = static_cast<size_t>(n);
  arena.take(&estimate->y, static_cast<size_t>(p));
  arena.take(&estimate->moved, 2 * lines);
  arena.take(&estimate->r, 2 * lines);
  arena.take(&estimate->J, 12 * lines);
  arena.take(&estimate->norms, lines);
}

void lay_out(int32_t n, int32_t p, Arena& arena, SolverMemory* memory) {
  const size_t lines = static_cast<size_t>(n);
  lay_out(n, p, arena, &memory->trial);
  arena.take(&memory->weights, lines);
  arena.take(&memory->roots, 2 * lines);
  arena.take(&memory->S, 4 * lines * lines);
  arena.take(&memory->X, 2 * lines * kColumns);
  arena.take(&memory->scratch, 2 * lines);
}

bool evaluate(const WhitenedLines& lines, Estimate* estimate) {
  std::fill(estimate->moved, estimate->moved + lines.m, 0.0);
  for (int32_t j = 0; j < lines.p; ++j) {
    math::add_multiple(estimate->y[j], lines.Vt + static_cast<ptrdiff_t>(j) * lines.m, estimate->moved, lines.m);
  }
  if (!line_residuals(*lines.cameras, lines.lines, lines.n, estimate->T, estimate->r, estimate->J)) return false;
  for (int32_t i = 0; i < lines.n; ++i) {
    double* r = estimate->r + 2 * i;
    whiten(lines.whitening + 4 * i, r, r + 1, 1);
    whiten(lines.whitening + 4 * i, estimate->J + 12 * i, estimate->J + 12 * i + 6, 6);
    for (int32_t k = 0; k < 2; ++k) r[k] += lines.shift[2 * i + k] + estimate->moved[2 * i + k];
    estimate->norms[i] = std::sqrt(r[0] * r[0] + r[1] * r[1]);
  }
  return true;
}

rvdnav_status minimise(const WhitenedLines& lines, const SolverOptions& options, Estimate* estimate,
                       SolverMemory* memory, Minimum* minimum) {
  if (!evaluate(lines, estimate)) return RVDNAV_ERROR_BEHIND;
  const int32_t n = lines.n;
  Loss loss = {RVDNAV_LOSS_HUBER, efficient_k(RVDNAV_LOSS_HUBER), kScaleFloor};
  bool starting = !options.near_minimum;
  if (!starting) loss = {options.loss, options.k, robust_scale(estimate->norms, n, kScaleFloor, memory->scratch)};
  PoseSystem system;
  double length = 0.0;
  *minimum = {};
  while (minimum->iterations < kMaxIterations && !minimum->converged) {
    if (starting) loss.scale = robust_scale(estimate->norms, n, kScaleFloor, memory->scratch);
    RVDNAV_TRY(linearise(lines, loss, *estimate, memory, &minimum->response, &system));
    if (!improve(lines, loss, system, memory, estimate, &length)) break;
    ++minimum->iterations;
    if (!starting) {
      minimum->converged = length < kConvergedStep;
    } else if (length < kStartStep || minimum->iterations == kStartIterations) {
      loss = {options.loss, options.k, robust_scale(estimate->norms, n, kScaleFloor, memory->scratch)};
      starting = false;
    }
  }
  RVDNAV_TRY(linearise(lines, loss, *estimate, memory, &minimum->response, &system));
  invert(system, minimum->inverse);
  return RVDNAV_OK;
}

}  // namespace rvdnav
