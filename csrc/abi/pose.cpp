// The steps of the pose estimation, each by itself, in memory that the caller lends for the call.
#include <cmath>

#include "abi/abi.hpp"
#include "abi/checks.hpp"
#include "pose/edge_lines.hpp"
#include "pose/refine.hpp"

using namespace rvdnav;

namespace {

constexpr uint32_t kMaxPoints = 1u << 20;
constexpr double kLargestAngle = 1e3;  // rad

bool is_camera(int32_t camera) { return camera >= 0 && camera < RVDNAV_CAMERAS; }

bool is_usable(const rvdnav_edge_point& point) {
  return is_camera(point.camera) && point.edge >= 0 && point.edge < RVDNAV_MAX_POSE_EDGES &&
         std::abs(point.x) <= kFar && std::abs(point.y) <= kFar && std::abs(point.nx) <= 2.0 &&
         std::abs(point.ny) <= 2.0 && point.sigma >= 0.0 && point.sigma <= kLargestSigma;
}

bool is_usable(const rvdnav_pose_line& line) {
  return is_camera(line.camera) && all_within(line.from_C, 3, kLargestLength) &&
         all_within(line.to_C, 3, kLargestLength) && std::abs(line.rho) <= kFar &&
         std::abs(line.theta) <= kLargestAngle && all_within(line.covariance, 4, kLargestEntry) &&
         line.shift_sigma >= 0.0 && line.shift_sigma <= kLargestSigma;
}

// The groups are those of all parameters.
bool are_usable(const rvdnav_pose_problem& problem) {
  uint64_t size = 0;
  for (uint32_t g = 0; g < problem.group_count; ++g) {
    const rvdnav_parameter_group& group = problem.groups[g];
    size += group.size;
    if (!(group.scale >= 1e-6 && group.scale <= 1e6 && group.weight >= 0.0)) return false;
    if (!(group.largest >= 1e-6 && group.largest <= 1e6)) return false;
  }
  return size == problem.parameter_count;
}

rvdnav_status check_problem(const rvdnav_pose_problem* problem) {
  if (problem == nullptr) return RVDNAV_ERROR_NULL;
  if (problem->struct_size != sizeof(*problem)) return RVDNAV_ERROR_STRUCT_SIZE;
  if (problem->line_count > RVDNAV_MAX_POSE_LINES || problem->parameter_count > RVDNAV_MAX_PARAMETERS ||
      problem->group_count > RVDNAV_MAX_GROUPS) {
    return RVDNAV_ERROR_CAPACITY;
  }
  if (problem->lines == nullptr && problem->line_count > 0) return RVDNAV_ERROR_NULL;
  const size_t n = problem->line_count, p = problem->parameter_count;
  if (p > 0 && (problem->information == nullptr || problem->vector == nullptr)) return RVDNAV_ERROR_NULL;
  if (p > 0 && n > 0 && problem->derivative == nullptr) return RVDNAV_ERROR_NULL;
  for (size_t i = 0; i < n; ++i) {
    if (!is_usable(problem->lines[i])) return RVDNAV_ERROR_ARGUMENT;
  }
  if (!are_cameras_usable(problem->cameras) || !are_usable(*problem)) return RVDNAV_ERROR_ARGUMENT;
  if (!is_rotation(problem->R_W_C) || !all_within(problem->p_W, 3, kLargestLength)) return RVDNAV_ERROR_ARGUMENT;
  if (problem->loss != RVDNAV_LOSS_TUKEY && problem->loss != RVDNAV_LOSS_HUBER) return RVDNAV_ERROR_ARGUMENT;
  if (!(problem->k >= 0.0 && problem->k <= kLargestSigma)) return RVDNAV_ERROR_ARGUMENT;
  if (problem->shown == 0 && !(problem->endpoint_sigma > 0.0 && problem->endpoint_sigma <= kLargestSigma)) {
    return RVDNAV_ERROR_ARGUMENT;
  }
  if (!all_within(problem->derivative, 2 * n * p, kLargestEntry)) return RVDNAV_ERROR_ARGUMENT;
  if (!all_within(problem->information, p * p, kLargestEntry)) return RVDNAV_ERROR_ARGUMENT;
  return all_within(problem->vector, p, kLargestEntry) ? RVDNAV_OK : RVDNAV_ERROR_ARGUMENT;
}

}  // namespace

rvdnav_status rvdnav_fit_edge_lines_size(uint32_t point_count, size_t* size) {
  if (size == nullptr) return RVDNAV_ERROR_NULL;
  if (point_count > kMaxPoints) return RVDNAV_ERROR_CAPACITY;
  Arena count;
  EdgeLineMemory unused = {};
  lay_out(point_count, count, &unused);
  *size = count.used();
  return RVDNAV_OK;
}

rvdnav_status rvdnav_fit_edge_lines(const rvdnav_edge_point* points, uint32_t point_count, void* memory, size_t size,
                                    rvdnav_edge_line* lines, uint32_t capacity, uint32_t* count, double* weights) {
  if (count == nullptr || (lines == nullptr && capacity > 0)) return RVDNAV_ERROR_NULL;
  if (point_count > 0 && (points == nullptr || weights == nullptr)) return RVDNAV_ERROR_NULL;
  size_t needed = 0;
  RVDNAV_TRY(rvdnav_fit_edge_lines_size(point_count, &needed));
  if (point_count > 0) RVDNAV_TRY(check_memory(memory, size, needed));
  for (uint32_t i = 0; i < point_count; ++i) {
    if (!is_usable(points[i])) return RVDNAV_ERROR_ARGUMENT;
  }
  Arena arena(memory, size);
  EdgeLineMemory work = {};
  lay_out(point_count, arena, &work);
  uint32_t total = 0;
  const uint32_t written = fit_edge_lines(points, point_count, work, lines, capacity, weights, &total);
  return finish_list(written, total, count);
}

rvdnav_status rvdnav_refine_pose_size(uint32_t line_count, uint32_t parameter_count, size_t* size) {
  if (size == nullptr) return RVDNAV_ERROR_NULL;
  if (line_count > RVDNAV_MAX_POSE_LINES || parameter_count > RVDNAV_MAX_PARAMETERS) return RVDNAV_ERROR_CAPACITY;
  Arena count;
  RefineMemory unused = {};
  lay_out(static_cast<int32_t>(line_count), static_cast<int32_t>(parameter_count), count, &unused);
  *size = count.used();
  return RVDNAV_OK;
}

rvdnav_status rvdnav_refine_pose(const rvdnav_pose_problem* problem, void* memory, size_t size,
                                 rvdnav_refined_pose* result) {
  RVDNAV_TRY(check_problem(problem));
  if (result == nullptr) return RVDNAV_ERROR_NULL;
  if (result->struct_size != sizeof(*result)) return RVDNAV_ERROR_STRUCT_SIZE;
  if ((result->told_information == nullptr) != (result->told_gradient == nullptr)) return RVDNAV_ERROR_NULL;
  size_t needed = 0;
  RVDNAV_TRY(rvdnav_refine_pose_size(problem->line_count, problem->parameter_count, &needed));
  RVDNAV_TRY(check_memory(memory, size, needed));
  Arena arena(memory, size);
  RefineMemory work = {};
  lay_out(static_cast<int32_t>(problem->line_count), static_cast<int32_t>(problem->parameter_count), arena, &work);
  Refinement refinement = {};
  RVDNAV_TRY(refine_pose(*problem, &work, &refinement));
  return report_pose(*problem, refinement, &work, result);
}
