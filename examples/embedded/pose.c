#include "pose.h"

static void multiply(const double* A, const double* B, double* AB) {
  for (int i = 0; i < 3; ++i) {
    for (int k = 0; k < 3; ++k) AB[3 * i + k] = A[3 * i] * B[k] + A[3 * i + 1] * B[3 + k] + A[3 * i + 2] * B[6 + k];
  }
}

static void multiply_transposed(const double* A, const double* B, double* AB_T) {
  for (int i = 0; i < 3; ++i) {
    for (int k = 0; k < 3; ++k) {
      AB_T[3 * i + k] = A[3 * i] * B[3 * k] + A[3 * i + 1] * B[3 * k + 1] + A[3 * i + 2] * B[3 * k + 2];
    }
  }
}

/* Rodrigues' vector g = axis x tan(angle / 2), and back: no sine is needed. */
static void rodrigues_of(const double* R, double* g) {
  const double w = 1.0 + R[0] + R[4] + R[8];
  g[0] = (R[7] - R[5]) / w;
  g[1] = (R[2] - R[6]) / w;
  g[2] = (R[3] - R[1]) / w;
}

static void rotation_of(const double* g, double* R) {
  const double square = g[0] * g[0] + g[1] * g[1] + g[2] * g[2];
  const double scale = 2.0 / (1.0 + square);
  const double cross[9] = {0.0, -g[2], g[1], g[2], 0.0, -g[0], -g[1], g[0], 0.0};
  for (int i = 0; i < 3; ++i) {
    for (int k = 0; k < 3; ++k) {
      const double one = i == k ? 1.0 - square * scale : 0.0;
      R[3 * i + k] = one + scale * (cross[3 * i + k] + g[i] * g[k]);
    }
  }
}

/* Lagrange's weights: the parabola through the history's values has at the time the sum of each times its weight. */
static void weigh(const Pose history[HISTORY], int64_t stamp_ns, double weights[HISTORY]) {
  for (int i = 0; i < HISTORY; ++i) {
    weights[i] = 1.0;
    for (int k = 0; k < HISTORY; ++k) {
      if (k == i) continue;
      weights[i] *= (double)(stamp_ns - history[k].stamp_ns) / (double)(history[i].stamp_ns - history[k].stamp_ns);
    }
  }
}

Pose predict_pose(const Pose history[HISTORY], int64_t stamp_ns) {
  double weights[HISTORY];
  weigh(history, stamp_ns, weights);
  Pose next = {.stamp_ns = stamp_ns};
  double turn[9], turned[3] = {0.0, 0.0, 0.0}; /* from the newest pose on */
  for (int i = 0; i < HISTORY; ++i) {
    double g[3];
    multiply_transposed(history[i].R_W_C, history[0].R_W_C, turn);
    rodrigues_of(turn, g);
    for (int axis = 0; axis < 3; ++axis) {
      next.p_W[axis] += weights[i] * history[i].p_W[axis];
      turned[axis] += weights[i] * g[axis];
    }
  }
  rotation_of(turned, turn);
  multiply(turn, history[0].R_W_C, next.R_W_C);
  return next;
}
