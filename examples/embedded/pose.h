/* Poses and how they go on. */
#ifndef POSE_H
#define POSE_H

#include <stdint.h>

typedef struct Pose {
  int64_t stamp_ns;
  double R_W_C[9]; /* row-major */
  double p_W[3];   /* metres */
} Pose;

/* Poses that a prediction goes on from. */
enum { HISTORY = 3 };

/* Where the last poses, the newest first, lead by a time if acceleration and angular acceleration stay; turns between
 * them below a quarter turn. */
Pose predict_pose(const Pose history[HISTORY], int64_t stamp_ns);

#endif
