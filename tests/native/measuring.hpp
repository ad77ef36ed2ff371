// The drawn bracket's edges, points known to 0.3 mm, and room for what is measured of them.
#pragma once

#include <cmath>
#include <vector>

#include "scene.hpp"

namespace scene {

constexpr int kCornersOfBar[4][2] = {{0, 1}, {2, 3}, {1, 2}, {3, 0}};  // of l1, l2, l3, l4
constexpr uint32_t kPoints = 8;
constexpr uint32_t kLasting = 3 * kPoints;
constexpr uint32_t kImages = RVDNAV_CAMERAS * RVDNAV_EDGES;  // of edges

// What the frames' lines have in common, too: a displacement for the steps of each view and one for each edge.
constexpr uint32_t kParameters = kLasting + RVDNAV_CAMERAS + RVDNAV_EDGES;

struct Measuring {
  std::vector<double> points, point_sigmas = std::vector<double>(kPoints, 3e-4), side_normals;
  std::vector<int32_t> ends, polarity = std::vector<int32_t>(kImages);
  std::vector<double> information = std::vector<double>(kLasting * kLasting), vector = std::vector<double>(kLasting);
  std::vector<double> start = std::vector<double>(kLasting);
  rvdnav_edge_model model = {};
  rvdnav_measurement_problem problem = {};

  std::vector<double> residuals = std::vector<double>(2 * kImages), weights = std::vector<double>(kImages);
  std::vector<double> gain = std::vector<double>(12 * kImages), z = std::vector<double>(kParameters);
  std::vector<double> joint = std::vector<double>((6 + kParameters) * (6 + kParameters)), told = joint;
  std::vector<double> gradient = std::vector<double>(6 + kParameters);
  std::vector<double> derivative = std::vector<double>(2 * kImages * kParameters);
  std::vector<double> taught = information, taught_vector = vector;
  std::vector<rvdnav_edge_evidence> evidence = std::vector<rvdnav_edge_evidence>(kImages);
  std::vector<rvdnav_pose_line> lines = std::vector<rvdnav_pose_line>(kImages);
  std::vector<int32_t> line_edges = std::vector<int32_t>(kImages);
  rvdnav_measurement result = {};

  // From where the bracket stands, less 2 mm of the range.
  explicit Measuring(const Placement& at) {
    set_model();
    const double c = std::cos(at.angle), s = std::sin(at.angle);
    problem.struct_size = sizeof problem;
    problem.lasting_count = kLasting;
    problem.model = &model;
    problem.cameras.focal = kFocal;
    problem.cameras.centre[0][2] = kBaseline;
    problem.cameras.R_rect_W[2] = -1.0;
    problem.cameras.R_rect_W[4] = problem.cameras.R_rect_W[6] = 1.0;
    const double R[9] = {c, 0.0, s, 0.0, 1.0, 0.0, -s, 0.0, c}, p[3] = {at.range - 0.002, at.y, at.z};
    for (int i = 0; i < 9; ++i) problem.R_W_C[i] = R[i];
    for (int i = 0; i < 3; ++i) problem.p_W[i] = p[i];
    problem.polarity = polarity.data();
    for (double& scale : problem.scales) scale = 1.0;
    problem.information = information.data();
    problem.vector = vector.data();
    problem.start = start.data();
    set_result();
  }
  Measuring(const Measuring&) = delete;

 private:
  void set_model() {
    const rvdnav_target t = target();
    for (const auto& corners : {t.outer, t.inner}) {
      for (int i = 0; i < 4; ++i) points.insert(points.end(), corners[i], corners[i] + 3);
    }
    for (int edge = 0; edge < RVDNAV_EDGES; ++edge) {
      const int* corners = kCornersOfBar[edge / 2];
      for (int i = 0; i < 2; ++i) ends.push_back(corners[i] + 4 * (edge % 2));
      // Outwards of a quadrilateral that runs as P1..P4 do, and into the opening.
      const double *from = t.outer[corners[0]], *to = t.outer[corners[1]];
      const double dy = to[1] - from[1], dz = to[2] - from[2], side = edge % 2 == 0 ? 1.0 : -1.0;
      const double length = side * std::sqrt(dy * dy + dz * dz);
      for (const double value : {0.0, dz / length, -dy / length}) side_normals.push_back(value);
    }
    model.struct_size = sizeof model;
    model.point_count = kPoints;
    model.edge_count = RVDNAV_EDGES;
    model.bracket = 1;
    model.thickness = t.thickness;
    model.points = points.data();
    model.point_sigmas = point_sigmas.data();
    model.ends = ends.data();
    model.side_normals = side_normals.data();
  }

  void set_result() {
    result.struct_size = sizeof result;
    result.pose.struct_size = sizeof result.pose;
    result.pose.residuals = residuals.data();
    result.pose.weights = weights.data();
    result.pose.gain = gain.data();
    result.pose.z = z.data();
    result.pose.joint_covariance = joint.data();
    result.pose.told_information = told.data();
    result.pose.told_gradient = gradient.data();
    result.evidence = evidence.data();
    result.lines = lines.data();
    result.line_edges = line_edges.data();
    result.derivative = derivative.data();
    result.taught_information = taught.data();
    result.taught_vector = taught_vector.data();
  }
};

}  // namespace scene
