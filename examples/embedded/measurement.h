/* The core's measurement of the bracket around a pose, with all the arrays that it needs.
 *
 * Bracket and calibration are taken to be exact.  Where they are known to a tolerance only, the problem has fields for
 * it, and the covariance grows by it. */
#ifndef MEASUREMENT_H
#define MEASUREMENT_H

#include "pose.h"
#include "rvdnav/rvdnav.h"
#include "sequence.h"

/* Once: takes memory from the pool. */
void measurement_start(const Sequence* sequence, rvdnav_context* context);

/* Measures around a prior that is good to two or three pixels.  polarity: of the edges' steps as last seen, zeros where
 * unknown.  Null where the images determine no pose; else what was found, until the next call. */
const rvdnav_measurement* measure(const Frame* frame, const Pose* prior,
                                  const int32_t polarity[RVDNAV_CAMERAS][RVDNAV_EDGES]);

#endif
