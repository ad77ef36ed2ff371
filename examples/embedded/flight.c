/* A flight program: stereo images in, poses of the bracket out, with or without an operating system.
 *
 * flight SEQUENCE [ISA]
 *
 * With three poses in a row the next one is predicted, and measured around the prediction.  Without them, or where the
 * images do not bear the prediction out, the bracket is searched for in the whole images.  A pose is published only if
 * its own measurement says that it is good.  Each frame's line ends with a hash of the measurement: it is the same on
 * every build. */
#include <stdbool.h>
#include <stddef.h>
#include <string.h>

#include "measurement.h"
#include "pose.h"
#include "program.h"
#include "telemetry.h"

/* What a measurement must show, as the settings of the same names in docs/algorithm.md. */
static const double EDGE_COVERAGE = 0.35, MIN_COVERAGE = 0.5;
static const double MAX_RMS_PX = 0.4;
static const double MAX_POSITION_SIGMA = 0.006;   /* metres */
static const double MAX_ATTITUDE_SIGMA = 0.01134; /* radians; times 1 + range / 1 m */
enum { MIN_EDGES = 5 };

/* What the frames before tell of the next one. */
typedef struct Track {
  int poses;             /* in a row */
  Pose history[HISTORY]; /* of them the newest first */
  int32_t polarity[RVDNAV_CAMERAS][RVDNAV_EDGES];
} Track;

/* What is told of a frame. */
typedef struct Solution {
  bool tracked;
  const char* refused; /* why there is no pose; null if there is one */
  const rvdnav_measurement* measurement;
} Solution;

/* Searches both views, one after the other, then joins them. */
static bool acquire(rvdnav_context* context, const Frame* frame, Pose* pose) {
  static rvdnav_view_result view[RVDNAV_CAMERAS];
  static rvdnav_frame_result result;
  const rvdnav_image* images[RVDNAV_CAMERAS] = {NULL, NULL};
  const rvdnav_view_result* views[RVDNAV_CAMERAS] = {NULL, NULL};
  for (int32_t camera = 0; camera < RVDNAV_CAMERAS; ++camera) {
    if (!frame->has[camera]) continue;
    images[camera] = &frame->image[camera];
    views[camera] = &view[camera];
    view[camera].struct_size = sizeof view[camera];
    check(rvdnav_view(context, camera, images[camera], NULL, 0, &view[camera]), "rvdnav_view");
  }
  result.struct_size = sizeof result;
  check(rvdnav_join(context, images[0], images[1], views[0], views[1], true, &result), "rvdnav_join");
  pose->stamp_ns = frame->stamp_ns;
  memcpy(pose->R_W_C, result.bracket.R_W_C, sizeof pose->R_W_C);
  memcpy(pose->p_W, result.bracket.p_W, sizeof pose->p_W);
  return result.bracket.found && !result.bracket.ambiguous;
}

/* Whether the views show enough of the bracket's edges where the pose has them. */
static bool is_shown(const rvdnav_measurement* measurement, const Frame* frame) {
  int attempted = 0, agreed = 0;
  for (int camera = 0; camera < RVDNAV_CAMERAS; ++camera) {
    int edges = 0;
    for (int edge = 0; edge < RVDNAV_EDGES; ++edge) {
      const rvdnav_edge_evidence* seen = &measurement->evidence[camera * RVDNAV_EDGES + edge];
      attempted += seen->attempted;
      agreed += seen->agreed;
      edges += seen->attempted > 0 && seen->agreed >= EDGE_COVERAGE * seen->attempted;
    }
    if (frame->has[camera] && edges < MIN_EDGES) return false;
  }
  return agreed >= MIN_COVERAGE * attempted;
}

/* Squared, weighted RMS of the lines' distances from the pose, pixels. */
static double mean_square(const rvdnav_measurement* measurement) {
  double sum = 0.0, weight = 0.0;
  for (uint32_t i = 0; i < measurement->line_count; ++i) {
    const double* r = &measurement->pose.residuals[2 * i];
    sum += measurement->pose.weights[i] * (r[0] * r[0] + r[1] * r[1]);
    weight += 2.0 * measurement->pose.weights[i];
  }
  return sum / weight;
}

/* Whether the standard deviations, all directions together, are within their limits. */
static bool is_certain(const rvdnav_refined_pose* pose) {
  const double* C = pose->covariance;
  const double range = pose->p_W[0] > 0.0 ? pose->p_W[0] : 0.0;
  const double attitude_limit = MAX_ATTITUDE_SIGMA * (1.0 + range);
  return C[0] + C[7] + C[14] <= MAX_POSITION_SIGMA * MAX_POSITION_SIGMA &&
         C[21] + C[28] + C[35] <= attitude_limit * attitude_limit;
}

/* Null if a measurement may be published. */
static const char* judge(const rvdnav_measurement* measurement, const Frame* frame) {
  if (measurement == NULL) return "no pose fits";
  if (!measurement->settled) return "not settled";
  if (!is_shown(measurement, frame)) return "too few edges";
  if (!(mean_square(measurement) <= MAX_RMS_PX * MAX_RMS_PX)) return "residuals";
  if (!is_certain(&measurement->pose)) return "too uncertain";
  return NULL;
}

static Solution solve(rvdnav_context* context, const Frame* frame, const Track* track) {
  Solution solution = {false, NULL, NULL};
  if (track->poses == HISTORY) {
    const Pose predicted = predict_pose(track->history, frame->stamp_ns);
    solution.measurement = measure(frame, &predicted, track->polarity);
    solution.refused = judge(solution.measurement, frame);
    solution.tracked = solution.refused == NULL;
    if (solution.tracked) return solution;
  }
  Pose acquired;
  if (!acquire(context, frame, &acquired)) return (Solution){false, "not found", NULL};
  static const int32_t unknown[RVDNAV_CAMERAS][RVDNAV_EDGES];
  solution.measurement = measure(frame, &acquired, unknown);
  solution.refused = judge(solution.measurement, frame);
  return solution;
}

static void remember(const Solution* solution, int64_t stamp_ns, Track* track) {
  if (solution->refused != NULL) {
    track->poses = 0;
    return;
  }
  const rvdnav_refined_pose* pose = &solution->measurement->pose;
  if (track->poses < HISTORY) ++track->poses;
  for (int i = HISTORY - 1; i > 0; --i) track->history[i] = track->history[i - 1];
  Pose* newest = &track->history[0];
  newest->stamp_ns = stamp_ns;
  memcpy(newest->R_W_C, pose->R_W_C, sizeof pose->R_W_C);
  memcpy(newest->p_W, pose->p_W, sizeof pose->p_W);
  for (int camera = 0; camera < RVDNAV_CAMERAS; ++camera) {
    for (int edge = 0; edge < RVDNAV_EDGES; ++edge) {
      track->polarity[camera][edge] = solution->measurement->evidence[camera * RVDNAV_EDGES + edge].polarity;
    }
  }
}

static void put_solution(int64_t stamp_ns, const Solution* solution) {
  put("frame ");
  put_unsigned((uint64_t)stamp_ns);
  if (solution->refused == NULL) {
    const rvdnav_refined_pose* pose = &solution->measurement->pose;
    put(solution->tracked ? " tracked" : " acquired");
    put(" p_W");
    put_vector(pose->p_W, 3, 6);
    put(" R_W_C");
    put_vector(pose->R_W_C, 9, 7);
    uint64_t value = hash(HASH_START, pose->R_W_C, sizeof pose->R_W_C);
    value = hash(value, pose->p_W, sizeof pose->p_W);
    value = hash(value, pose->covariance, sizeof pose->covariance);
    put(" hash ");
    put_hash(value);
  } else {
    put(" ");
    put(solution->refused);
  }
  put_newline();
}

int main(int argc, char** argv) {
  static Sequence sequence;
  rvdnav_context* context = program_start(argc, argv, &sequence);
  measurement_start(&sequence, context);
  Track track = {0};
  for (uint32_t number = 0; number < sequence.frame_count; ++number) {
    Frame frame;
    sequence_read(&sequence, &frame);
    const Solution solution = solve(context, &frame, &track);
    remember(&solution, frame.stamp_ns, &track);
    put_solution(frame.stamp_ns, &solution);
  }
  put_memory();
  return 0;
}
