// The pose's calls over the C ABI: a pose that is known, refusals, and numbers of any size.
#include <doctest/doctest.h>

#include <cmath>
#include <limits>
#include <random>
#include <vector>

#include "lent.hpp"
#include "rvdnav/rvdnav.h"

namespace {

constexpr double kInfinity = std::numeric_limits<double>::infinity();
constexpr double kNone = std::numeric_limits<double>::quiet_NaN();
constexpr double kFocal = 700.0;
constexpr uint32_t kLines = 16;
constexpr uint32_t kParameters = 5;

Lent lent(uint32_t lines, uint32_t parameters) {
  size_t size = 0;
  REQUIRE(rvdnav_refine_pose_size(lines, parameters, &size) == RVDNAV_OK);
  return Lent(size);
}

// A quadrilateral and a smaller one inside it, 1 m in front of cameras whose axes are those of W.
struct Scene {
  std::vector<rvdnav_pose_line> lines;
  std::vector<double> derivative, information, vector;
  rvdnav_pose_problem problem = {};
  std::vector<double> residuals = std::vector<double>(2 * kLines), weights = std::vector<double>(kLines);
  std::vector<double> z = std::vector<double>(kParameters);
  rvdnav_refined_pose result = {};

  Scene() : derivative(2 * kLines * kParameters), information(kParameters * kParameters), vector(kParameters) {
    problem.struct_size = sizeof problem;
    problem.cameras.focal = kFocal;
    problem.cameras.centre[1][0] = 0.2;
    for (int i = 0; i < 3; ++i) problem.R_W_C[4 * i] = problem.cameras.R_rect_W[4 * i] = 1.0;
    problem.p_W[2] = 1.01;
    problem.shown = 1;
    for (int camera = 0; camera < 2; ++camera) {
      for (int edge = 0; edge < 8; ++edge) lines.push_back(line(camera, edge));
    }
    problem.lines = lines.data();
    problem.line_count = kLines;
    for (uint32_t i = 0; i < derivative.size(); ++i) derivative[i] = 0.01 * std::sin(1.0 * i);
    problem.parameter_count = kParameters;
    problem.group_count = 2;
    problem.groups[0] = {3, 0, 1.0, 1.0, 5.0};
    problem.groups[1] = {2, 0, 1.0, kInfinity, 5.0};
    problem.derivative = derivative.data();
    problem.information = information.data();
    problem.vector = vector.data();
    result.struct_size = sizeof result;
    result.residuals = residuals.data();
    result.weights = weights.data();
    result.z = z.data();
  }

  static rvdnav_pose_line line(int camera, int edge) {
    const double corners[5][2] = {{-0.2, -0.1}, {0.2, -0.12}, {0.15, 0.12}, {-0.15, 0.1}, {-0.2, -0.1}};
    const double size = edge < 4 ? 1.0 : 0.8;
    rvdnav_pose_line line = {};
    line.camera = camera;
    for (int i = 0; i < 2; ++i) {
      line.from_C[i] = size * corners[edge % 4][i];
      line.to_C[i] = size * corners[edge % 4 + 1][i];
    }
    // Its image from a metre away.
    const double shift = camera == 1 ? 0.2 : 0.0;
    const double x0 = kFocal * (line.from_C[0] - shift), y0 = kFocal * line.from_C[1];
    const double x1 = kFocal * (line.to_C[0] - shift), y1 = kFocal * line.to_C[1];
    line.theta = std::atan2(x1 - x0, y0 - y1);
    line.rho = x0 * std::cos(line.theta) + y0 * std::sin(line.theta);
    line.covariance[0] = 1e-4;
    line.covariance[3] = 1e-8;
    return line;
  }

  rvdnav_status refine() {
    const Lent memory = lent(problem.line_count, problem.parameter_count);
    const rvdnav_status status = rvdnav_refine_pose(&problem, memory.data(), memory.size(), &result);
    CHECK(memory.intact());
    return status;
  }
};

}  // namespace

TEST_CASE("exact lines give the pose, with parameters and without any output array") {
  Scene scene;
  REQUIRE(scene.refine() == RVDNAV_OK);
  CHECK(scene.result.converged == 1);
  CHECK(std::abs(scene.result.p_W[2] - 1.0) < 1e-9);
  CHECK(std::abs(scene.result.p_W[0]) < 1e-9);
  CHECK(std::abs(scene.result.R_W_C[0] - 1.0) < 1e-9);
  for (const double r : scene.residuals) CHECK(std::abs(r) < 1e-6);
  for (const double w : scene.weights) CHECK(w > 0.99);
  Scene bare;
  bare.result.residuals = bare.result.weights = bare.result.z = nullptr;
  bare.problem.parameter_count = bare.problem.group_count = 0;
  REQUIRE(bare.refine() == RVDNAV_OK);
  CHECK(std::abs(bare.result.p_W[2] - 1.0) < 1e-9);
}

TEST_CASE("what is out of its range is refused") {
  const auto refused = [](auto change) {
    Scene scene;
    change(scene);
    return scene.refine();
  };
  CHECK(refused([](Scene& s) { s.problem.struct_size -= 8; }) == RVDNAV_ERROR_STRUCT_SIZE);
  CHECK(refused([](Scene& s) { s.result.struct_size += 8; }) == RVDNAV_ERROR_STRUCT_SIZE);
  CHECK(refused([](Scene& s) { s.problem.lines = nullptr; }) == RVDNAV_ERROR_NULL);
  CHECK(refused([](Scene& s) { s.problem.derivative = nullptr; }) == RVDNAV_ERROR_NULL);
  CHECK(refused([](Scene& s) { s.result.told_gradient = s.z.data(); }) == RVDNAV_ERROR_NULL);
  CHECK(refused([](Scene& s) { s.problem.group_count = 9; }) == RVDNAV_ERROR_CAPACITY);
  CHECK(refused([](Scene& s) { s.lines[3].camera = 2; }) == RVDNAV_ERROR_ARGUMENT);
  CHECK(refused([](Scene& s) { s.lines[3].rho = kNone; }) == RVDNAV_ERROR_ARGUMENT);
  CHECK(refused([](Scene& s) { s.lines[3].to_C[1] = kInfinity; }) == RVDNAV_ERROR_ARGUMENT);
  CHECK(refused([](Scene& s) { s.derivative[7] = kNone; }) == RVDNAV_ERROR_ARGUMENT);
  CHECK(refused([](Scene& s) { s.vector[1] = kInfinity; }) == RVDNAV_ERROR_ARGUMENT);
  CHECK(refused([](Scene& s) { s.problem.R_W_C[0] = 1.1; }) == RVDNAV_ERROR_ARGUMENT);
  CHECK(refused([](Scene& s) { s.problem.cameras.focal = 0.0; }) == RVDNAV_ERROR_ARGUMENT);
  CHECK(refused([](Scene& s) { s.problem.loss = 2; }) == RVDNAV_ERROR_ARGUMENT);
  CHECK(refused([](Scene& s) { s.problem.shown = 0; }) == RVDNAV_ERROR_ARGUMENT);  // without a sigma
  CHECK(refused([](Scene& s) { s.problem.groups[0].size = 4; }) == RVDNAV_ERROR_ARGUMENT);
  CHECK(refused([](Scene& s) { s.problem.groups[0].scale = 0.0; }) == RVDNAV_ERROR_ARGUMENT);
  size_t size = 0;
  CHECK(rvdnav_refine_pose_size(513, 0, &size) == RVDNAV_ERROR_CAPACITY);
  CHECK(rvdnav_refine_pose_size(0, 2049, &size) == RVDNAV_ERROR_CAPACITY);
  const Lent memory = lent(kLines, kParameters);
  Scene scene;
  CHECK(rvdnav_refine_pose(&scene.problem, memory.data(), memory.size() - 1, &scene.result) == RVDNAV_ERROR_MEMORY);
}

TEST_CASE("what determines no pose is told from what is behind the cameras") {
  Scene few;
  few.problem.line_count = 2;
  CHECK(few.refine() == RVDNAV_ERROR_UNDETERMINED);
  Scene behind;
  behind.problem.p_W[2] = -1.0;
  CHECK(behind.refine() == RVDNAV_ERROR_BEHIND);
  Scene indefinite;
  indefinite.information[0] = -4.0;
  CHECK(indefinite.refine() == RVDNAV_ERROR_UNDETERMINED);
}

TEST_CASE("numbers of any size end in a pose or in a status") {
  std::mt19937_64 random(11);
  std::uniform_real_distribution<double> unit(-1.0, 1.0);
  std::uniform_int_distribution<size_t> any;
  int refined = 0;
  for (int round = 0; round < 300; ++round) {
    Scene scene;
    const auto wild = [&] { return unit(random) * std::pow(10.0, 12.0 * unit(random)); };
    for (int changes = 0; changes < 3; ++changes) {
      rvdnav_pose_line& line = scene.lines[any(random) % kLines];
      double* const places[] = {&line.from_C[any(random) % 3],
                                &line.rho,
                                &line.theta,
                                &line.covariance[any(random) % 4],
                                &line.shift_sigma,
                                &scene.derivative[any(random) % scene.derivative.size()],
                                &scene.information[any(random) % scene.information.size()],
                                &scene.vector[any(random) % scene.vector.size()],
                                &scene.problem.p_W[any(random) % 3]};
      *places[any(random) % 9] = wild();
    }
    const rvdnav_status status = scene.refine();
    CHECK((status == RVDNAV_OK || status == RVDNAV_ERROR_ARGUMENT || status <= RVDNAV_ERROR_UNDETERMINED));
    if (status == RVDNAV_OK) {
      ++refined;
      CHECK(std::isfinite(scene.result.p_W[2]));
      CHECK(std::isfinite(scene.result.covariance[0]));
    }
  }
  CHECK(refined > 50);
}

TEST_CASE("lines through places") {
  std::vector<rvdnav_edge_point> points;
  for (int i = 0; i < 40; ++i) {
    const double t = i;
    points.push_back({1, 7, 10.0 + 0.6 * t, 20.0 + 0.8 * t, -0.8, 0.6, 0.1});
    points.push_back({0, 255, t, 5.0 + (i == 20 ? 9.0 : 0.0), 0.0, 1.0, 0.1});
    if (i < 3) points.push_back({0, 3, t, t, 0.6, 0.8, 0.1});
  }
  const uint32_t n = static_cast<uint32_t>(points.size());
  std::vector<double> weights(n);
  rvdnav_edge_line lines[4];
  uint32_t count = 0;
  size_t size = 0;
  REQUIRE(rvdnav_fit_edge_lines_size(n, &size) == RVDNAV_OK);
  const Lent memory(size);
  const auto fit = [&](uint32_t capacity) {
    return rvdnav_fit_edge_lines(points.data(), n, memory.data(), size, lines, capacity, &count, weights.data());
  };
  REQUIRE(fit(4) == RVDNAV_OK);
  REQUIRE(count == 2);
  CHECK(lines[0].edge == 255);
  CHECK(lines[0].rho == doctest::Approx(5.0));
  CHECK(lines[1].camera == 1);
  CHECK(lines[1].rho == doctest::Approx(-0.8 * 10.0 + 0.6 * 20.0));
  CHECK(weights[1] == doctest::Approx(1.0));
  CHECK(weights[2] == 0.0);  // too few on this edge
  int outliers = 0;
  for (const double w : weights) outliers += w == 0.0;
  CHECK(outliers == 4);
  CHECK(fit(1) == RVDNAV_ERROR_CAPACITY);
  CHECK(count == 2);
  CHECK(memory.intact());
  points[5].edge = RVDNAV_MAX_POSE_EDGES;
  CHECK(fit(4) == RVDNAV_ERROR_ARGUMENT);
  points[5].edge = 1;
  points[5].x = kNone;
  CHECK(fit(4) == RVDNAV_ERROR_ARGUMENT);
}
