// The pose's calls and the calibration's: a scene that has a solution, disturbed.
#include <cmath>

#include "parts.hpp"

namespace {

constexpr double kFocal = 700.0;

// A line of a quadrilateral, or of a smaller one inside it, a metre in front of cameras whose axes are those of W.
rvdnav_pose_line scene_line(uint32_t i) {
  constexpr double kCorners[5][2] = {{-0.2, -0.1}, {0.2, -0.12}, {0.15, 0.12}, {-0.15, 0.1}, {-0.2, -0.1}};
  const uint32_t edge = i / 2 % 8;
  const double size = edge < 4 ? 1.0 : 0.8;
  rvdnav_pose_line line = {};
  line.camera = static_cast<int32_t>(i % 2);
  for (int k = 0; k < 2; ++k) {
    line.from_C[k] = size * kCorners[edge % 4][k];
    line.to_C[k] = size * kCorners[edge % 4 + 1][k];
  }
  const double shift = line.camera == 1 ? 0.2 : 0.0;
  const double x0 = kFocal * (line.from_C[0] - shift), y0 = kFocal * line.from_C[1];
  const double x1 = kFocal * (line.to_C[0] - shift), y1 = kFocal * line.to_C[1];
  line.theta = std::atan2(x1 - x0, y0 - y1);
  line.rho = x0 * std::cos(line.theta) + y0 * std::sin(line.theta);
  line.covariance[0] = 1e-4;
  line.covariance[3] = 1e-8;
  return line;
}

std::vector<double> numbers(Noise& random, size_t count, double size) {
  std::vector<double> made(count);
  for (double& value : made) value = size * random.real();
  return made;
}

// A number that is counted in, or too large a one.
uint32_t count_from(Input& input, uint32_t most, uint32_t limit) {
  return input.one_in(32) ? limit + 1 + input.take<uint32_t>() % 1000 : input.below(most + 1);
}

rvdnav_pose_problem scene_problem(Input& input, uint32_t lines, uint32_t parameters) {
  rvdnav_pose_problem problem = {};
  problem.cameras.focal = kFocal;
  problem.cameras.centre[1][0] = 0.2;
  for (int i = 0; i < 3; ++i) problem.R_W_C[4 * i] = problem.cameras.R_rect_W[4 * i] = 1.0;
  problem.p_W[2] = 1.01;
  problem.shown = input.one_in(2) ? 1 : 0;
  problem.endpoint_sigma = 0.1;
  problem.loss = input.one_in(4) ? RVDNAV_LOSS_HUBER : RVDNAV_LOSS_TUKEY;
  problem.group_count = 2;
  const uint32_t first = parameters < 3 ? parameters : 3;
  problem.groups[0] = {first, 1, 1.0, 1.0, 5.0};
  problem.groups[1] = {parameters - first, 0, 1.0, INFINITY, 5.0};
  disturb_sized(input, 4, &problem);
  problem.struct_size = sizeof(problem);
  problem.line_count = lines;
  problem.parameter_count = parameters;
  return problem;
}

}  // namespace

void fuzz_edge_lines(Input& input) {
  std::vector<rvdnav_edge_point> points(input.below(64));
  Noise random(input);
  const double scatter = input.take<uint8_t>() / 16.0;
  for (size_t i = 0; i < points.size(); ++i) {
    const double along = static_cast<double>(i);
    points[i] = {
        static_cast<int32_t>(i % 2), static_cast<int32_t>(i / 32), along, 5.0 + scatter * random.real(), 0.0, 1.0, 0.1};
  }
  disturb_all(input, 6, &points);
  size_t size = 0;
  rvdnav_fit_edge_lines_size(input.take<uint32_t>(), &size);
  const auto count = static_cast<uint32_t>(points.size());
  require(rvdnav_fit_edge_lines_size(count, &size) == RVDNAV_OK);
  const Memory memory = aligned(size);
  std::vector<rvdnav_edge_line> lines(input.below(5));
  std::vector<double> weights(points.size());
  uint32_t found = 0;
  rvdnav_fit_edge_lines(points.data(), count, memory.get(), size, lines.data(), static_cast<uint32_t>(lines.size()),
                        &found, weights.data());
}

void fuzz_pose(Input& input) {
  const uint32_t n = count_from(input, 20, RVDNAV_MAX_POSE_LINES), p = count_from(input, 8, RVDNAV_MAX_PARAMETERS);
  size_t size = 0;
  if (rvdnav_refine_pose_size(n, p, &size) != RVDNAV_OK) size = 64;
  rvdnav_pose_problem problem = scene_problem(input, n, p);
  const bool large = n > RVDNAV_MAX_POSE_LINES || p > RVDNAV_MAX_PARAMETERS;  // refused before anything is read
  const size_t lines_made = large ? 0 : n, made = large ? 0 : p;
  std::vector<rvdnav_pose_line> lines(lines_made);
  for (size_t i = 0; i < lines.size(); ++i) lines[i] = scene_line(static_cast<uint32_t>(i));
  disturb_all(input, 6, &lines);
  Noise random(input);
  std::vector<double> derivative = numbers(random, 2 * lines_made * made, 0.01);
  std::vector<double> information = numbers(random, made * made, 0.01), vector = numbers(random, made, 1.0);
  for (std::vector<double>* array : {&derivative, &information, &vector}) disturb_all(input, 2, array);
  problem.lines = lines.data();
  problem.derivative = derivative.data();
  problem.information = information.data();
  problem.vector = vector.data();

  const size_t all = 6 + made;
  std::vector<double> residuals(2 * lines_made), weights(lines_made), gain(12 * lines_made), z(made);
  std::vector<double> joint(all * all), told(all * all), gradient(all);
  rvdnav_refined_pose result = {};
  result.struct_size = sizeof(result);
  if (!input.one_in(8)) {
    result.residuals = residuals.data();
    result.weights = weights.data();
    result.gain = gain.data();
    result.z = z.data();
    result.joint_covariance = joint.data();
    result.told_information = told.data();
    result.told_gradient = gradient.data();
  }
  const Memory memory = aligned(size);
  if (rvdnav_refine_pose(&problem, memory.get(), size, &result) != RVDNAV_OK) return;
  for (const double value : result.p_W) require(std::isfinite(value));
  for (const double value : result.R_W_C) require(std::isfinite(value));
  for (const double value : result.covariance) require(std::isfinite(value));
}

void fuzz_calibration(Input& input) {
  constexpr size_t kTerms = 12;
  rvdnav_rig rig = {};
  rig.struct_size = sizeof(rig);
  rig.width = 704;
  rig.height = 576;
  rig.camera_count = RVDNAV_CAMERAS;
  rig.focal_rect = 670.0;
  rig.baseline = 0.12;
  for (rvdnav_camera& c : rig.camera) {
    c = {670.0, 670.0, 351.5, 287.5, -0.1, 0.02, 1e-4, 1e-4, {1, 0, 0, 0, 1, 0, 0, 0, 1}};
  }
  disturb_sized(input, 4, &rig);
  rvdnav_calibration_effect effect = {};
  effect.struct_size = sizeof(effect);
  effect.parameters = count_from(input, 4, 64);
  const size_t p = effect.parameters > 64 ? 0 : effect.parameters;
  Noise random(input);
  std::vector<double> shift = numbers(random, RVDNAV_CAMERAS * kTerms * kTerms * 2 * p, 1.0);
  std::vector<double> focal = numbers(random, p, 1.0), centres = numbers(random, RVDNAV_CAMERAS * 3 * p, 0.01);
  for (std::vector<double>* array : {&shift, &focal, &centres}) disturb_all(input, 2, array);
  effect.shift = shift.data();
  effect.focal = focal.data();
  effect.centers = centres.data();
  std::vector<rvdnav_measured_line> lines(3, {-100.0, 0.1, {{-0.15, -0.2, 1.0}, {-0.17, 0.2, 1.0}}, 0, 0});
  lines[1].camera = 1;
  disturb_all(input, 6, &lines);
  std::vector<double> derivatives(lines.size() * 2 * p);
  rvdnav_calibration_derivatives(&rig, &effect, lines.data(), static_cast<uint32_t>(lines.size()), derivatives.data());
}
