// What a caller can ask of the library itself.
#include <string.h>

#include "rvdnav/rvdnav.h"

uint32_t rvdnav_abi_version(void) { return RVDNAV_ABI_VERSION; }

const char* rvdnav_status_text(rvdnav_status status) {
  switch (status) {
    case RVDNAV_OK:
      return "ok";
    case RVDNAV_ERROR_NULL:
      return "a required pointer is null";
    case RVDNAV_ERROR_STRUCT_SIZE:
      return "struct_size is not one this library knows";
    case RVDNAV_ERROR_ARGUMENT:
      return "an argument is out of its range";
    case RVDNAV_ERROR_MEMORY:
      return "the memory given is too small or misaligned";
    case RVDNAV_ERROR_CONTEXT:
      return "not an initialised context of this version";
    case RVDNAV_ERROR_IMAGE:
      return "the image's size or stride does not fit the context";
    case RVDNAV_ERROR_CAPACITY:
      return "an output array is too small";
    case RVDNAV_ERROR_CALIBRATION:
      return "a camera or rig parameter is not usable";
    case RVDNAV_ERROR_TARGET:
      return "the bracket is degenerate";
    case RVDNAV_ERROR_ISA:
      return "this processor or build lacks the instruction set asked for";
    case RVDNAV_ERROR_THREAD:
      return "the worker thread could not be started";
    case RVDNAV_ERROR_UNDETERMINED:
      return "the measurements do not determine the pose";
    case RVDNAV_ERROR_BEHIND:
      return "a point of the target is not in front of the camera";
    case RVDNAV_ERROR_NO_AGREEMENT:
      return "no measurement agrees with the pose";
    default:
      return "unknown status";
  }
}

uint32_t rvdnav_struct_size(const char* name) {
  static const struct {
    const char* name;
    uint32_t size;
  } kSizes[] = {
      {"rvdnav_image", sizeof(rvdnav_image)},
      {"rvdnav_camera", sizeof(rvdnav_camera)},
      {"rvdnav_rig", sizeof(rvdnav_rig)},
      {"rvdnav_target", sizeof(rvdnav_target)},
      {"rvdnav_config", sizeof(rvdnav_config)},
      {"rvdnav_fields", sizeof(rvdnav_fields)},
      {"rvdnav_edgel", sizeof(rvdnav_edgel)},
      {"rvdnav_peak", sizeof(rvdnav_peak)},
      {"rvdnav_segment", sizeof(rvdnav_segment)},
      {"rvdnav_bar", sizeof(rvdnav_bar)},
      {"rvdnav_window", sizeof(rvdnav_window)},
      {"rvdnav_line", sizeof(rvdnav_line)},
      {"rvdnav_model_edge", sizeof(rvdnav_model_edge)},
      {"rvdnav_seen_edge", sizeof(rvdnav_seen_edge)},
      {"rvdnav_edge_coverage", sizeof(rvdnav_edge_coverage)},
      {"rvdnav_edge_sample", sizeof(rvdnav_edge_sample)},
      {"rvdnav_calibration_effect", sizeof(rvdnav_calibration_effect)},
      {"rvdnav_measured_line", sizeof(rvdnav_measured_line)},
      {"rvdnav_match", sizeof(rvdnav_match)},
      {"rvdnav_surface_point", sizeof(rvdnav_surface_point)},
      {"rvdnav_edge_point", sizeof(rvdnav_edge_point)},
      {"rvdnav_edge_line", sizeof(rvdnav_edge_line)},
      {"rvdnav_pose_cameras", sizeof(rvdnav_pose_cameras)},
      {"rvdnav_pose_line", sizeof(rvdnav_pose_line)},
      {"rvdnav_parameter_group", sizeof(rvdnav_parameter_group)},
      {"rvdnav_pose_problem", sizeof(rvdnav_pose_problem)},
      {"rvdnav_refined_pose", sizeof(rvdnav_refined_pose)},
      {"rvdnav_edge_model", sizeof(rvdnav_edge_model)},
      {"rvdnav_motion", sizeof(rvdnav_motion)},
      {"rvdnav_measurement_problem", sizeof(rvdnav_measurement_problem)},
      {"rvdnav_edge_evidence", sizeof(rvdnav_edge_evidence)},
      {"rvdnav_measurement", sizeof(rvdnav_measurement)},
      {"rvdnav_view_result", sizeof(rvdnav_view_result)},
      {"rvdnav_bracket", sizeof(rvdnav_bracket)},
      {"rvdnav_frame_result", sizeof(rvdnav_frame_result)},
  };
  if (name == nullptr) return 0;
  for (const auto& entry : kSizes) {
    if (strcmp(name, entry.name) == 0) return entry.size;
  }
  return 0;
}
