// The measurement of a pose around a coarse one, in memory that the caller lends for the call.
#include "navigator/measurement.hpp"

#include <cmath>

#include "abi/abi.hpp"
#include "abi/checks.hpp"

using namespace rvdnav;

namespace {

constexpr double kLargestSpeed = 1e4;  // m/s and rad/s
constexpr double kLongestRow = 1.0;    // s
constexpr double kLargestScale = 1e6;

bool are_polarities(const int32_t* values, size_t count) {
  for (size_t i = 0; i < count; ++i) {
    if (values[i] < -1 || values[i] > 1) return false;
  }
  return true;
}

rvdnav_status check_faces(const rvdnav_edge_model& model) {
  if (model.face_count == 0) return RVDNAV_OK;
  if (model.face_count > RVDNAV_MAX_FACES || model.corner_count < 3 || model.corner_count > RVDNAV_MAX_CORNERS) {
    return RVDNAV_ERROR_CAPACITY;
  }
  const size_t faces = model.face_count;
  for (const void* array : {static_cast<const void*>(model.face_normals), static_cast<const void*>(model.face_origins),
                            static_cast<const void*>(model.face_axes), static_cast<const void*>(model.face_corners),
                            static_cast<const void*>(model.adjoining)}) {
    if (array == nullptr) return RVDNAV_ERROR_NULL;
  }
  const bool usable = all_within(model.face_normals, 3 * faces, 1.0 + 1e-6) &&
                      all_within(model.face_origins, 3 * faces, kLargestLength) &&
                      all_within(model.face_axes, 6 * faces, 1.0 + 1e-6) &&
                      all_within(model.face_corners, 2 * faces * model.corner_count, kLargestLength) &&
                      model.touch >= 0.0 && model.touch <= kLargestLength;
  return usable ? RVDNAV_OK : RVDNAV_ERROR_TARGET;
}

rvdnav_status check_model(const rvdnav_edge_model& model) {
  if (model.struct_size != sizeof(model)) return RVDNAV_ERROR_STRUCT_SIZE;
  if (model.point_count > RVDNAV_MAX_POINTS || model.edge_count > RVDNAV_MAX_POSE_EDGES) return RVDNAV_ERROR_CAPACITY;
  if (model.points == nullptr || model.point_sigmas == nullptr || model.ends == nullptr) return RVDNAV_ERROR_NULL;
  if (model.point_count < 2 || model.edge_count < 1) return RVDNAV_ERROR_TARGET;
  if (!all_within(model.points, 3 * static_cast<size_t>(model.point_count), kLargestLength)) return RVDNAV_ERROR_TARGET;
  for (uint32_t i = 0; i < model.point_count; ++i) {
    if (!(model.point_sigmas[i] >= 0.0 && model.point_sigmas[i] <= kLargestLength)) return RVDNAV_ERROR_TARGET;
  }
  for (uint32_t i = 0; i < model.edge_count; ++i) {
    const int32_t from = model.ends[2 * i], to = model.ends[2 * i + 1], count = static_cast<int32_t>(model.point_count);
    if (from < 0 || from >= count || to < 0 || to >= count || from == to) return RVDNAV_ERROR_TARGET;
  }
  if (model.bracket != 0) {
    if (model.side_normals == nullptr) return RVDNAV_ERROR_NULL;
    const bool usable = model.edge_count == RVDNAV_EDGES && all_within(&model.thickness, 1, kLargestLength) &&
                        all_within(model.side_normals, 3 * RVDNAV_EDGES, 1.0 + 1e-6);
    if (!usable) return RVDNAV_ERROR_TARGET;
  }
  return check_faces(model);
}

bool is_possible(const rvdnav_motion& motion) {
  if (motion.row_seconds == 0.0) return true;
  return motion.row_seconds > 0.0 && motion.row_seconds <= kLongestRow &&
         all_within(motion.velocity, 6, kLargestSpeed) && all_within(motion.covariance, 36, kLargestEntry);
}

// Structure, pointers and ranges; then the numbers of parameters are known.
rvdnav_status check_problem(const rvdnav_context* context, const rvdnav_measurement_problem* problem) {
  RVDNAV_TRY(check_context(context));
  if (problem == nullptr) return RVDNAV_ERROR_NULL;
  if (problem->struct_size != sizeof(*problem)) return RVDNAV_ERROR_STRUCT_SIZE;
  if (problem->model == nullptr || problem->polarity == nullptr) return RVDNAV_ERROR_NULL;
  RVDNAV_TRY(check_model(*problem->model));
  const int32_t views = context->context.rig.camera_count;
  if (problem->effect != nullptr) RVDNAV_TRY(check_effect(*problem->effect, views));
  if (!is_possible(problem->motion)) return RVDNAV_ERROR_ARGUMENT;
  const ParameterCounts counts = parameter_counts(*problem, views);
  if (counts.all() > RVDNAV_MAX_PARAMETERS) return RVDNAV_ERROR_CAPACITY;
  const size_t q = static_cast<size_t>(counts.lasting());
  if (problem->lasting_count != q) return RVDNAV_ERROR_ARGUMENT;
  if (q > 0 && (problem->information == nullptr || problem->vector == nullptr || problem->start == nullptr)) {
    return RVDNAV_ERROR_NULL;
  }
  for (const double scale : problem->scales) {
    if (!(scale >= 1.0 / kLargestScale && scale <= kLargestScale)) return RVDNAV_ERROR_ARGUMENT;
  }
  const bool usable = are_cameras_usable(problem->cameras) && is_rotation(problem->R_W_C) &&
                      all_within(problem->p_W, 3, kLargestLength) &&
                      are_polarities(problem->polarity, static_cast<size_t>(views) * problem->model->edge_count) &&
                      all_within(problem->information, q * q, kLargestEntry) &&
                      all_within(problem->vector, q, kLargestEntry) && all_within(problem->start, q, kLargestEntry);
  return usable ? RVDNAV_OK : RVDNAV_ERROR_ARGUMENT;
}

bool has_arrays(const rvdnav_measurement& measurement, bool lasting) {
  const rvdnav_refined_pose& pose = measurement.pose;
  for (const double* array : {pose.residuals, pose.weights, pose.gain, pose.z, pose.joint_covariance,
                              pose.told_information, pose.told_gradient, measurement.derivative}) {
    if (array == nullptr) return false;
  }
  if (lasting && (measurement.taught_information == nullptr || measurement.taught_vector == nullptr)) return false;
  return measurement.evidence != nullptr && measurement.lines != nullptr && measurement.line_edges != nullptr;
}

rvdnav_status set_images(const rvdnav_context* context, const rvdnav_image* left, const rvdnav_image* right,
                         Scene* scene) {
  const rvdnav_image* const given[RVDNAV_CAMERAS] = {left, right};
  for (int32_t camera = 0; camera < scene->views; ++camera) {
    scene->present[camera] = given[camera] != nullptr;
    if (!scene->present[camera]) continue;
    RVDNAV_TRY(check_image(context, given[camera]));
    scene->images[camera] = grey_view(*given[camera]);
  }
  return scene->present[0] || scene->present[1] ? RVDNAV_OK : RVDNAV_ERROR_NULL;
}

}  // namespace

rvdnav_status rvdnav_measure_size(const rvdnav_context* context, const rvdnav_measurement_problem* problem,
                                  size_t* size, uint32_t* parameter_count) {
  if (size == nullptr || parameter_count == nullptr) return RVDNAV_ERROR_NULL;
  RVDNAV_TRY(check_problem(context, problem));
  const int32_t views = context->context.rig.camera_count;
  Arena count;
  MeasurementMemory unused = {};
  lay_out(*problem, views, count, &unused);
  *size = count.used();
  *parameter_count = static_cast<uint32_t>(parameter_counts(*problem, views).all());
  return RVDNAV_OK;
}

rvdnav_status rvdnav_measure(const rvdnav_context* context, const rvdnav_image* left, const rvdnav_image* right,
                             const rvdnav_measurement_problem* problem, void* memory, size_t size,
                             rvdnav_measurement* measurement) {
  size_t needed = 0;
  uint32_t parameters = 0;
  RVDNAV_TRY(rvdnav_measure_size(context, problem, &needed, &parameters));
  RVDNAV_TRY(check_memory(memory, size, needed));
  if (measurement == nullptr) return RVDNAV_ERROR_NULL;
  if (measurement->struct_size != sizeof(*measurement)) return RVDNAV_ERROR_STRUCT_SIZE;
  if (!has_arrays(*measurement, problem->lasting_count > 0)) return RVDNAV_ERROR_NULL;
  const Context& c = context->context;
  Scene scene = {&c.rig,
                 problem,
                 {},
                 {},
                 c.config.blur_sigma,
                 c.rig.camera_count,
                 static_cast<int32_t>(problem->model->edge_count)};
  RVDNAV_TRY(set_images(context, left, right, &scene));
  Arena arena(memory, size);
  MeasurementMemory work = {};
  lay_out(*problem, scene.views, arena, &work);
  return measure(scene, &work, measurement);
}
