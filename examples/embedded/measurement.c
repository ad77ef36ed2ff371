#include "measurement.h"

#include <stddef.h>
#include <string.h>

#include "pool.h"
#include "program.h"

enum {
  LINES = RVDNAV_CAMERAS * RVDNAV_EDGES,
  PARAMETERS = RVDNAV_CAMERAS + RVDNAV_EDGES, /* a displacement of the steps for each camera, one for each edge */
  JOINT = 6 + PARAMETERS                      /* with the pose */
};

static double residuals[LINES][2], weights[LINES], gain[6][LINES][2], z[PARAMETERS];
static double joint_covariance[JOINT][JOINT], told_information[JOINT][JOINT], told_gradient[JOINT];
static double derivative[LINES][2][PARAMETERS];
static rvdnav_edge_evidence evidence[RVDNAV_CAMERAS][RVDNAV_EDGES];
static rvdnav_pose_line lines[LINES];
static int32_t line_edges[LINES];

static const double exact[RVDNAV_APEXES]; /* standard deviations of the apexes' coordinates */
static rvdnav_edge_model model;
static rvdnav_measurement_problem problem;
static rvdnav_measurement measurement;
static rvdnav_context* context;
static void* memory;
static size_t memory_size;

static void describe_bracket(const Sequence* sequence) {
  model = (rvdnav_edge_model){
      .struct_size = sizeof model,
      .point_count = RVDNAV_APEXES,
      .edge_count = RVDNAV_EDGES,
      .bracket = 1,
      .thickness = sequence->target.thickness,
      .points = sequence->edges.points[0],
      .point_sigmas = exact,
      .ends = sequence->edges.ends[0],
      .side_normals = sequence->edges.side_normals[0],
  };
  problem = (rvdnav_measurement_problem){
      .struct_size = sizeof problem,
      .model = &model,
      .cameras = sequence->cameras,
      .scales = {1.0, 1.0, 1.0, 1.0, 1.0},
  };
}

static void lend_arrays(void) {
  measurement = (rvdnav_measurement){
      .struct_size = sizeof measurement,
      .pose = {.struct_size = sizeof measurement.pose,
               .residuals = residuals[0],
               .weights = weights,
               .gain = gain[0][0],
               .z = z,
               .joint_covariance = joint_covariance[0],
               .told_information = told_information[0],
               .told_gradient = told_gradient},
      .evidence = evidence[0],
      .lines = lines,
      .line_edges = line_edges,
      .derivative = derivative[0][0],
  };
}

void measurement_start(const Sequence* sequence, rvdnav_context* of_sequence) {
  context = of_sequence;
  describe_bracket(sequence);
  static const int32_t unknown[RVDNAV_CAMERAS][RVDNAV_EDGES];
  problem.polarity = unknown[0];
  problem.R_W_C[0] = problem.R_W_C[4] = problem.R_W_C[8] = 1.0;
  uint32_t parameters = 0;
  check(rvdnav_measure_size(context, &problem, &memory_size, &parameters), "rvdnav_measure_size");
  if (parameters > PARAMETERS) check(RVDNAV_ERROR_CAPACITY, "rvdnav_measure_size");
  memory = pool_take(memory_size);
}

const rvdnav_measurement* measure(const Frame* frame, const Pose* prior,
                                  const int32_t polarity[RVDNAV_CAMERAS][RVDNAV_EDGES]) {
  memcpy(problem.R_W_C, prior->R_W_C, sizeof problem.R_W_C);
  memcpy(problem.p_W, prior->p_W, sizeof problem.p_W);
  problem.polarity = polarity[0];
  lend_arrays();
  const rvdnav_image* left = frame->has[0] ? &frame->image[0] : NULL;
  const rvdnav_image* right = frame->has[1] ? &frame->image[1] : NULL;
  const rvdnav_status status = rvdnav_measure(context, left, right, &problem, memory, memory_size, &measurement);
  switch (status) {
    case RVDNAV_ERROR_UNDETERMINED:
    case RVDNAV_ERROR_BEHIND:
    case RVDNAV_ERROR_NO_AGREEMENT:
      return NULL;
    default:
      check(status, "rvdnav_measure");
      return &measurement;
  }
}
