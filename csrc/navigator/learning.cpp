#include "navigator/learning.hpp"

#include <algorithm>
#include <cmath>

#include "math/matrix.hpp"

namespace rvdnav {
namespace {

constexpr int32_t kPose = 6;
// Of the tolerance of a point, what all of them have in common.
constexpr double kCommonPart = 0.5;

ptrdiff_t at(int32_t row, int32_t column, int32_t columns) { return static_cast<ptrdiff_t>(row) * columns + column; }

// Pose and parameters of one frame, in the order of the told information: the pose, q lasting ones, k - 6 of the frame.
struct Split {
  int32_t q, k, all;
  int32_t rest(int32_t i) const { return i < kPose ? i : i + q; }
};

// The inverse variances of the groups as the frame shows them: of each of the frame's own parameters.
double prior_of_rest(const ParameterCounts& counts, const double* scales, int32_t i) {
  const int32_t own = i - kPose;
  if (own < 0) return 0.0;
  const int32_t group = own < counts.views ? 2 : own < counts.views + counts.edges ? 3 : 4;
  return 1.0 / (scales[group] * scales[group]);
}

// The factor of A, and U^-T of B and of the pull.
bool eliminate_rest(const ParameterCounts& counts, const Split& split, const rvdnav_refined_pose& pose,
                    LearningMemory* memory) {
  const int32_t k = split.k, q = split.q;
  for (int32_t i = 0; i < k; ++i) {
    const double* told = pose.told_information + at(split.rest(i), 0, split.all);
    for (int32_t j = 0; j < k; ++j) memory->A[at(i, j, k)] = told[split.rest(j)];
    std::copy(told + kPose, told + kPose + q, memory->B + at(i, 0, q + 1));
    const double prior = prior_of_rest(counts, pose.scales, i);
    const double z = i < kPose ? 0.0 : pose.z[i - kPose + q];
    memory->A[at(i, i, k)] += prior;
    memory->B[at(i, q, q + 1)] = pose.told_gradient[split.rest(i)] + prior * z;
    for (int32_t c = 0; c < kPose; ++c) memory->selected[at(i, c, kPose)] = i == c ? 1.0 : 0.0;
  }
  if (!math::cholesky(memory->A, k)) return false;
  math::solve_lower(memory->A, k, memory->B, q + 1);
  math::solve_lower(memory->A, k, memory->selected, kPose);
  return true;
}

// What the lines tell of the lasting parameters, whatever the pose and the frame's own ones are.
void teach(const Split& split, const rvdnav_refined_pose& pose, const LearningMemory& memory, double* information,
           double* vector) {
  const int32_t q = split.q;
  for (int32_t i = 0; i < q; ++i) {
    const double* told = pose.told_information + at(kPose + i, kPose, split.all);
    std::copy(told, told + q, information + at(i, 0, q));
    vector[i] = -pose.told_gradient[kPose + i];
  }
  for (int32_t r = 0; r < split.k; ++r) {
    const double* b = memory.B + at(r, 0, q + 1);
    for (int32_t i = 0; i < q; ++i) math::add_multiple(-b[i], b + i, information + at(i, i, q), q - i);
    math::add_multiple(b[q], b, vector, q);
  }
  math::mirror(information, q);
  for (int32_t i = 0; i < q; ++i) vector[i] += math::dot(information + at(i, 0, q), pose.z, q);
}

// reach (q, 6): how the pose follows the lasting parameters, U^-T of it by a factor U of their information.
bool add_reach(const Split& split, const LearningMemory& memory, const double* information, double* U, double sign,
               double* covariance) {
  const int32_t q = split.q;
  std::copy(information, information + at(q, 0, q), U);
  if (!math::cholesky(U, q)) return false;
  std::fill(memory.reach, memory.reach + at(q, 0, kPose), 0.0);
  for (int32_t r = 0; r < split.k; ++r) {
    const double *b = memory.B + at(r, 0, q + 1), *s = memory.selected + at(r, 0, kPose);
    for (int32_t i = 0; i < q; ++i) math::add_multiple(b[i], s, memory.reach + at(i, 0, kPose), kPose);
  }
  math::solve_lower(U, q, memory.reach, kPose);
  math::add_square(sign, memory.reach, q, kPose, covariance);
  return true;
}

// What errs in this frame alone, and what the frame changed of the lasting parameters: by how much less is known of
// them without it.
bool fill_own_covariance(const rvdnav_measurement_problem& problem, const ParameterCounts& counts, const Split& split,
                         const double* taught, LearningMemory* memory, rvdnav_measurement* measurement) {
  const int32_t q = split.q;
  double* covariance = measurement->own_covariance;
  std::fill(covariance, covariance + kPose * kPose, 0.0);
  math::add_square(1.0, memory->selected, split.k, kPose, covariance);
  std::copy(problem.information, problem.information + at(q, 0, q), memory->prior);
  for (int32_t i = 0; i < q; ++i) {
    const double scale = measurement->pose.scales[i < counts.points ? 0 : 1];
    memory->prior[at(i, i, q)] += 1.0 / (scale * scale);
  }
  if (!add_reach(split, *memory, memory->prior, memory->posterior, 1.0, covariance)) return false;
  for (int32_t i = 0; i < q * q; ++i) memory->prior[i] += taught[i];
  if (!add_reach(split, *memory, memory->prior, memory->posterior, -1.0, covariance)) return false;
  math::mirror(covariance, kPose);
  return true;
}

// Variance of what all points have in common at the scale that the frame shows, m^2.
double common_variance(const rvdnav_edge_model& model, double scale) {
  double sum = 0.0, count = 0.0;
  for (uint32_t i = 0; i < model.point_count; ++i) {
    const double sigma = model.point_sigmas[i];
    if (!(sigma > 0.0)) continue;
    sum += sigma * sigma;
    count += 1.0;
  }
  return count > 0.0 ? kCommonPart * kCommonPart * sum / count * scale * scale : 0.0;
}

}  // namespace

void lay_out(const ParameterCounts& counts, Arena& arena, LearningMemory* memory) {
  const size_t q = static_cast<size_t>(counts.lasting()), k = static_cast<size_t>(kPose + counts.all()) - q;
  arena.take(&memory->A, k * k);
  arena.take(&memory->B, k * (q + 1));
  arena.take(&memory->selected, k * kPose);
  arena.take(&memory->prior, q * q);
  arena.take(&memory->posterior, q * q);
  arena.take(&memory->reach, q * kPose);
}

bool learn_from_frame(const Scene& scene, LearningMemory* memory, rvdnav_measurement* measurement) {
  const ParameterCounts counts = parameter_counts(*scene.problem, scene.views);
  const Split split = {counts.lasting(), kPose + counts.all() - counts.lasting(), kPose + counts.all()};
  if (!eliminate_rest(counts, split, measurement->pose, memory)) return false;
  teach(split, measurement->pose, *memory, measurement->taught_information, measurement->taught_vector);
  if (!fill_own_covariance(*scene.problem, counts, split, measurement->taught_information, memory, measurement)) {
    return false;
  }
  const double common = common_variance(scene.model(), measurement->pose.scales[0]);
  for (int32_t i = 0; i < 3; ++i) measurement->pose.covariance[7 * i] += common;
  return true;
}

}  // namespace rvdnav
