#include <doctest/doctest.h>

#include <cmath>

#include "apexes.hpp"
#include "bracket_views.hpp"
#include "refit.hpp"
#include "stepped_images.hpp"

using namespace rvdnav;
using stepped::draw;
using stepped::small_rig;

namespace {

constexpr double kBlur = 0.7;
const double kLensBlur = std::sqrt(kBlur * kBlur - 1.0 / 12.0);

// As tracking leaves it: found, off by what a peak may be off.
rvdnav_line tracked(double rho, double theta, double t_min, double t_max) {
  rvdnav_line line = {};
  line.found = 1;
  line.votes = 40;
  line.rho = rho;
  line.theta = theta;
  line.t_min = t_min;
  line.t_max = t_max;
  return line;
}

Eigen::Matrix2d covariance_of(const rvdnav_line& line) {
  return (Eigen::Matrix2d() << line.covariance[0], line.covariance[1], line.covariance[2], line.covariance[3])
      .finished();
}

}  // namespace

TEST_CASE("a tracked line is refitted to the grey values") {
  plain::Random random(90);
  const rvdnav_rig rig = small_rig();
  for (int i = 0; i < 30; ++i) {
    const double theta = random.real(-0.78, 2.35), rho = random.real(-15, 15);
    const Line2 truth = Line2::from_angle(rho, theta);
    const plain::Grey image = draw(rig, 0, truth, {50.0, kLensBlur, {{0.0, i % 2 == 0 ? 100.0 : -40.0}}}, 1.5, random);
    // Turned about its middle, which is not its foot point.
    const double middle = random.real(-10, 10), half = random.real(15, 30), turn = random.real(-0.015, 0.015);
    rvdnav_line line =
        tracked(rho + random.real(-0.8, 0.8) + middle * turn, theta + turn, middle - half, middle + half);
    refit_line(rig, 0, image.view(), kBlur, &line);
    REQUIRE(line.refitted == 1);
    CHECK(line.votes == 40);
    CHECK(line.samples >= static_cast<uint32_t>(2 * half) - 8);
    CHECK(line.rms < 0.15);
    const Line2 fitted = Line2::from_angle(line.rho, line.theta);
    CHECK(line.theta >= -0.25 * kPi);
    CHECK(line.theta < 0.75 * kPi);
    CHECK(std::abs(fitted.distance(truth.at(middle))) < 0.04);
    CHECK(std::abs(line_angle_difference(line.theta, theta)) < 0.006);
  }
}

TEST_CASE("the covariance of a refit is honest") {
  plain::Random random(91);
  const rvdnav_rig rig = small_rig(120, 90);
  for (const double middle : {0.0, 18.0}) {
    double squared = 0.0;
    constexpr int kRuns = 80;
    for (int i = 0; i < kRuns; ++i) {
      // Another phase of the pixels every time.
      const double theta = 0.8 + random.real(-0.3, 0.3), rho = random.real(-3, 3);
      const Line2 truth = Line2::from_angle(rho, theta);
      const plain::Grey image = draw(rig, 0, truth, {50.0, kLensBlur, {{0.0, 100.0}}}, 3.0, random);
      rvdnav_line line = tracked(rho, theta, middle - 20, middle + 20);
      refit_line(rig, 0, image.view(), kBlur, &line);
      REQUIRE(line.refitted == 1);
      const Eigen::Vector2d error(line.rho - rho, line.theta - theta);
      const Eigen::Matrix2d covariance = covariance_of(line);
      CHECK(covariance.determinant() > 0.0);
      squared += error.dot(covariance.inverse() * error) / 2.0;
    }
    CHECK(squared / kRuns > 0.6);
    CHECK(squared / kRuns < 2.2);  // neighbouring profiles share pixels, which their scatter does not show
  }
}

TEST_CASE("the covariance turns with the line across the end of the theta range") {
  plain::Random random(92);
  const rvdnav_rig rig = small_rig();
  const double theta = -0.25 * kPi + 0.002;
  const Line2 truth = Line2::from_angle(6.0, theta - 0.005);  // beyond the end
  const plain::Grey image = draw(rig, 0, truth, {50.0, kLensBlur, {{0.0, 100.0}}}, 1.0, random);
  rvdnav_line line = tracked(6.0, theta, -5.0, 45.0);
  refit_line(rig, 0, image.view(), kBlur, &line);
  REQUIRE(line.refitted == 1);
  CHECK(line.theta == doctest::Approx(0.75 * kPi - 0.003).epsilon(0.001));
  CHECK(line.rho == doctest::Approx(-6.0).epsilon(0.02));
  CHECK(line.t_min == -45.0);
  CHECK(line.t_max == 5.0);
  // The line is known best in its middle: var(rho + t theta) is least there.
  const Eigen::Matrix2d c = covariance_of(line);
  const auto variance_at = [&](double t) {
    const Eigen::Vector2d J(-1.0, t);
    return J.dot(c * J);
  };
  CHECK(variance_at(-20.0) < 0.5 * variance_at(-45.0));
  CHECK(variance_at(-20.0) < 0.5 * variance_at(5.0));
}

TEST_CASE("outliers do not bend a refit") {
  plain::Random random(93);
  const rvdnav_rig rig = small_rig();
  const Line2 truth = Line2::from_angle(3.0, 0.2);
  plain::Grey image = draw(rig, 0, truth, {40.0, kLensBlur, {{0.0, 100.0}}}, 1.0, random);
  // A bright spot covers a fifth of it.
  for (int32_t y = 70; y < 82; ++y) {
    for (int32_t x = 60; x < 83; ++x) image.at(x, y) = 140;
  }
  rvdnav_line line = tracked(3.0, 0.2, -30.0, 30.0);
  refit_line(rig, 0, image.view(), kBlur, &line);
  REQUIRE(line.refitted == 1);
  CHECK(line.rho == doctest::Approx(3.0).epsilon(0.02));
  CHECK(std::abs(line.theta - 0.2) < 0.003);
}

TEST_CASE("a line without grey values behind it stays as it was") {
  plain::Random random(94);
  const rvdnav_rig rig = small_rig();
  const plain::Grey flat = draw(rig, 0, Line2::from_angle(0, 0), {80.0, kLensBlur, {}}, 1.0, random);
  const auto stays = [&](const rvdnav_line& before) {
    rvdnav_line line = before;
    refit_line(rig, 0, flat.view(), kBlur, &line);
    return line.refitted == 0 && line.rho == before.rho && line.theta == before.theta && line.covariance[0] == 0.0 &&
           line.t_min == before.t_min && line.t_max == before.t_max;
  };
  CHECK(stays(tracked(5.0, 0.4, -30, 30)));
  CHECK(stays(tracked(5.0, 0.4, -4, 4)));     // too short
  CHECK(stays(tracked(5.0, 0.4, 300, 400)));  // off the image
  CHECK(stays(tracked(500.0, 0.4, -30, 30)));
}

TEST_CASE("apexes are where the bracket's corners are seen") {
  plain::Random random(95);
  const rvdnav_target target = scene::target();
  for (int i = 0; i < 40; ++i) {
    const Pose pose = views::random_pose(random, 0.4, 1.5, 0.5, M_PI);
    const int camera = i % 2;
    rvdnav_line lines[RVDNAV_EDGES] = {};
    for (int edge = 0; edge < RVDNAV_EDGES; ++edge) {
      const auto [a, b] = views::edge_image(camera, pose, edge);
      const rvdnav_segment s = views::segment_between(a, b, a);
      lines[edge] = tracked(s.rho, s.theta, s.t_min, s.t_max);
    }
    double apexes[RVDNAV_APEXES][2];
    REQUIRE(intersect_lines(lines, apexes) == 0xff);
    for (int apex = 0; apex < RVDNAV_APEXES; ++apex) {
      const Eigen::Vector2d seen =
          views::image_of(camera, pose, apex < 4 ? target.outer[apex] : target.inner[apex - 4]);
      CHECK(apexes[apex][0] == doctest::Approx(seen.x()));
      CHECK(apexes[apex][1] == doctest::Approx(seen.y()));
    }
    // Without the outer edge of l1 there is neither P1 nor P2, without the inner one of l4 neither Q4 nor Q1.
    lines[0].found = lines[7].found = 0;
    CHECK(intersect_lines(lines, apexes) == (0xff & ~(1U << 0 | 1U << 1 | 1U << 7 | 1U << 4)));
    CHECK(apexes[0][0] == 0.0);
    // Lines that nearly coincide meet nowhere in particular.
    lines[0] = lines[4];
    lines[0].theta += 0.05;
    CHECK((intersect_lines(lines, apexes) & 1U << 1) == 0);
  }
}
