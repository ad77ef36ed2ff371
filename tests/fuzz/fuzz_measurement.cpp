// The measurement of a pose: two quadrilaterals, one within the other, as a bracket or as a target of any kind with a
// face before half of it, disturbed.
#include <cmath>

#include "parts.hpp"

namespace {

constexpr uint32_t kPoints = 8;
constexpr uint32_t kCorners = 4;

struct Model {
  std::vector<double> points, point_sigmas, side_normals;
  std::vector<int32_t> ends;
  std::vector<double> face_normals, face_origins, face_axes, face_corners;
  std::vector<uint8_t> adjoining;
  rvdnav_edge_model in_c = {};

  explicit Model(Input& input) : point_sigmas(kPoints), side_normals(3 * RVDNAV_EDGES) {
    constexpr double kSide[kCorners][2] = {{-1, -1}, {1, -1}, {1, 1}, {-1, 1}};
    for (const double size : {0.2, 0.15}) {
      for (const auto& side : kSide) points.insert(points.end(), {0.0, size * side[0], size * side[1]});
    }
    const double sigma = input.one_in(2) ? 1e-3 : 0.0;
    for (double& value : point_sigmas) value = sigma;
    for (int32_t edge = 0; edge < RVDNAV_EDGES; ++edge) {
      const int32_t from = edge / 2, first = edge % 2 == 0 ? 0 : 4;
      ends.insert(ends.end(), {first + from, first + (from + 1) % 4});
      side_normals[static_cast<size_t>(3 * edge + 1)] = 1.0;
    }
    face_normals = {-1.0, 0.0, 0.0};
    face_origins = {-0.05, -0.2, -0.2};
    face_axes = {0.0, 1.0, 0.0, 0.0, 0.0, 1.0};
    face_corners = {0.0, 0.0, 0.4, 0.0, 0.4, 0.2, 0.0, 0.2};
    adjoining.resize(RVDNAV_EDGES);
    in_c.bracket = input.one_in(2) ? 1 : 0;
    in_c.thickness = 0.01;
    in_c.touch = 1e-6;
    in_c.face_count = input.one_in(2) ? 1 : 0;
    in_c.corner_count = kCorners;
    in_c.point_count = kPoints;
    in_c.edge_count = RVDNAV_EDGES;
    disturb_all(input, 3, &points);
    disturb_all(input, 2, &point_sigmas);
    disturb_all(input, 2, &ends);
    for (std::vector<double>* array : {&side_normals, &face_normals, &face_origins, &face_axes, &face_corners}) {
      disturb_all(input, 1, array);
    }
    disturb(input, 2, offsetof(rvdnav_edge_model, thickness), offsetof(rvdnav_edge_model, points), &in_c);
    in_c.struct_size = sizeof(in_c);
    in_c.points = points.data();
    in_c.point_sigmas = point_sigmas.data();
    in_c.ends = ends.data();
    in_c.side_normals = side_normals.data();
    in_c.face_normals = face_normals.data();
    in_c.face_origins = face_origins.data();
    in_c.face_axes = face_axes.data();
    in_c.face_corners = face_corners.data();
    in_c.adjoining = adjoining.data();
  }
  Model(const Model&) = delete;

  uint32_t lasting() const {
    uint32_t count = 0;
    for (const double sigma : point_sigmas) count += sigma > 0.0 ? 3 : 0;
    return count;
  }
};

rvdnav_measurement_problem base_problem(Input& input, const rvdnav_rig& rig) {
  rvdnav_measurement_problem problem = {};
  problem.cameras.focal = rig.focal_rect;
  problem.cameras.centre[0][2] = rig.baseline;
  problem.cameras.R_rect_W[2] = -1.0;
  problem.cameras.R_rect_W[4] = problem.cameras.R_rect_W[6] = 1.0;
  for (int i = 0; i < 3; ++i) problem.R_W_C[4 * i] = 1.0;
  problem.p_W[0] = 0.5;
  for (double& scale : problem.scales) scale = 1.0;
  if (input.one_in(4)) {
    problem.motion.row_seconds = 1e-3;
    for (int i = 0; i < 6; ++i) problem.motion.covariance[7 * i] = 1e-2;
  }
  disturb_sized(input, 4, &problem);
  problem.struct_size = sizeof(problem);
  return problem;
}

}  // namespace

void fuzz_measurement(Input& input) {
  Prepared prepared;
  if (!prepare(input, &prepared)) return;
  const Picture left(input, prepared.rig), right(input, prepared.rig);
  const Model model(input);
  rvdnav_measurement_problem problem = base_problem(input, prepared.rig);
  const size_t q = model.lasting(), n = static_cast<size_t>(prepared.rig.camera_count) * RVDNAV_EDGES;
  std::vector<int32_t> polarity(n);
  std::vector<double> information(q * q), vector(q), start(q);
  for (std::vector<double>* array : {&information, &vector, &start}) disturb_all(input, 2, array);
  problem.lasting_count = static_cast<uint32_t>(q);
  problem.model = &model.in_c;
  problem.effect = nullptr;
  problem.polarity = polarity.data();
  problem.information = information.data();
  problem.vector = vector.data();
  problem.start = start.data();
  size_t size = 0;
  uint32_t parameters = 0;
  if (rvdnav_measure_size(prepared.context, &problem, &size, &parameters) != RVDNAV_OK) return;

  const size_t p = parameters, all = 6 + p;
  std::vector<double> residuals(2 * n), weights(n), gain(12 * n), z(p), joint(all * all), told(all * all),
      gradient(all);
  std::vector<double> derivative(2 * n * p), taught(q * q), taught_vector(q);
  std::vector<rvdnav_edge_evidence> evidence(n);
  std::vector<rvdnav_pose_line> lines(n);
  std::vector<int32_t> line_edges(n);
  rvdnav_measurement result = {};
  result.struct_size = sizeof(result);
  result.pose = {sizeof(result.pose),
                 0,
                 0,
                 0,
                 {},
                 {},
                 {},
                 0.0,
                 0.0,
                 {},
                 residuals.data(),
                 weights.data(),
                 gain.data(),
                 z.data(),
                 joint.data(),
                 told.data(),
                 gradient.data()};
  result.evidence = evidence.data();
  result.lines = lines.data();
  result.line_edges = line_edges.data();
  result.derivative = derivative.data();
  result.taught_information = taught.data();
  result.taught_vector = taught_vector.data();
  const Memory memory = aligned(size);
  const bool stereo = prepared.rig.camera_count == RVDNAV_CAMERAS;
  const rvdnav_status status = rvdnav_measure(prepared.context, left.image(), stereo ? right.image() : nullptr,
                                              &problem, memory.get(), size, &result);
  if (status != RVDNAV_OK) return;
  for (const double value : result.pose.p_W) require(std::isfinite(value));
  for (const double value : result.pose.covariance) require(std::isfinite(value));
  for (const double value : result.own_covariance) require(std::isfinite(value));
}
