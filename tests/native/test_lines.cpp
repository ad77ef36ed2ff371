#include <doctest/doctest.h>

#include <algorithm>
#include <cmath>
#include <vector>

#include <Eigen/Eigenvalues>

#include "edgel_lines.hpp"
#include "lines.hpp"

using namespace rvdnav;

namespace {

constexpr SegmentLimits kLimits = {16.0, 6.0};

// Edgels as rectification leaves them: on the line up to noise across it, in units of 1/32 pixel.
void add_noisy(std::vector<rvdnav_edgel>& edgels, const plain::Line& line, plain::Random& random, double noise) {
  const double c = std::cos(plain::radians(line.theta_deg)), s = std::sin(plain::radians(line.theta_deg));
  for (double t = line.t_min; t <= line.t_max; t += 1.0) {
    const double rho = line.rho + random.real(-noise, noise);
    const double degrees = line.theta_deg + (line.flipped ? 180.0 : 0.0) + random.real(-3.0, 3.0);
    edgels.push_back({static_cast<int32_t>(std::lround(32.0 * (rho * c - t * s))),
                      static_cast<int32_t>(std::lround(32.0 * (rho * s + t * c))),
                      static_cast<uint8_t>(std::lround(degrees * 256.0 / 360.0) & 255),
                      {}});
  }
}

rvdnav_peak peak_at(double rho, double theta_deg) {
  return {static_cast<int32_t>(std::lround(rho * 256.0)), static_cast<int32_t>(std::lround(theta_deg * 256.0)), 50};
}

struct Found {
  std::vector<rvdnav_segment> segments;
  uint32_t total;
};

Found extract(const std::vector<rvdnav_edgel>& edgels, const std::vector<rvdnav_peak>& peaks, uint32_t capacity = 64) {
  std::vector<uint32_t> order(edgels.size());
  std::vector<LineScratch::Member> members(edgels.size());
  LineScratch scratch = {};
  scratch.order = order.data();
  scratch.members = members.data();
  Found found = {std::vector<rvdnav_segment>(capacity), 0};
  const uint32_t n = extract_segments(edgels.data(), static_cast<uint32_t>(edgels.size()), peaks.data(),
                                      static_cast<uint32_t>(peaks.size()), kLimits, scratch, found.segments.data(),
                                      capacity, &found.total);
  found.segments.resize(n);
  return found;
}

}  // namespace

TEST_CASE("a segment is the total least squares line of its edgels") {
  plain::Random random(40);
  for (int i = 0; i < 100; ++i) {
    const double middle = random.real(-150, 150), half = random.real(15, 60);
    const plain::Line line = {random.real(-200, 200), random.real(-45.0, 134.9), middle - half, middle + half,
                              i % 2 == 0};
    std::vector<rvdnav_edgel> edgels;
    add_noisy(edgels, line, random, 0.5);
    // The oracle: mean, and the eigenvector of the smallest eigenvalue.
    Eigen::Vector2d mean = Eigen::Vector2d::Zero();
    for (const rvdnav_edgel& e : edgels) mean += Eigen::Vector2d(e.x_q5, e.y_q5) / 32.0;
    mean /= static_cast<double>(edgels.size());
    Eigen::Matrix2d scatter = Eigen::Matrix2d::Zero();
    for (const rvdnav_edgel& e : edgels) {
      const Eigen::Vector2d d = Eigen::Vector2d(e.x_q5, e.y_q5) / 32.0 - mean;
      scatter += d * d.transpose();
    }
    const Eigen::SelfAdjointEigenSolver<Eigen::Matrix2d> eigen(scatter);
    const Eigen::Vector2d normal = eigen.eigenvectors().col(0);

    plain::add_clutter(edgels, 300, random);
    // The peak lies off by what a Hough bin may be off.
    const double off = random.real(-0.4, 0.4);
    const double turn = random.real(-0.3, 0.3);
    const Found found =
        extract(edgels, {peak_at(line.rho + off + middle * plain::radians(turn), line.theta_deg + turn)});
    REQUIRE(found.segments.size() >= 1);
    const rvdnav_segment& s = found.segments[0];
    const Eigen::Vector2d n(std::cos(s.theta), std::sin(s.theta));
    CHECK(s.theta >= -0.25 * M_PI);
    CHECK(s.theta < 0.75 * M_PI);
    // A rare edgel of the clutter may fall on it.
    CHECK(std::abs(n.x() * normal.y() - n.y() * normal.x()) < 0.01);
    CHECK(std::abs(n.dot(mean) - s.rho) < 0.1);
    CHECK(plain::distance_at_ends(line, s.rho, s.theta) < 0.6);
    const bool turned = std::abs(s.theta - plain::radians(line.theta_deg)) > 1.0;  // across the end of theta's range
    CHECK(std::abs((turned ? -s.t_min : s.t_max) - line.t_max) < 3.0);
    CHECK(std::abs((turned ? -s.t_max : s.t_min) - line.t_min) < 3.0);
    CHECK(s.polarity == ((line.flipped != turned) ? -1 : 1));
    CHECK(s.support >= 2.0 * half - 1.0);
    CHECK(s.rms < 0.45);
    CHECK(s.rms > 0.15);
  }
}

TEST_CASE("gaps part segments, short and sparse ones are left out") {
  plain::Random random(41);
  std::vector<rvdnav_edgel> edgels;
  const double rho = 30.0, theta = 12.0;
  add_noisy(edgels, {rho, theta, -100.0, -50.0}, random, 0.2);
  add_noisy(edgels, {rho, theta, -45.0, -20.0}, random, 0.2);  // a gap of 5: bridged
  add_noisy(edgels, {rho, theta, 0.0, 40.0}, random, 0.2);     // a gap of 20: not
  add_noisy(edgels, {rho, theta, 60.0, 72.0}, random, 0.2);    // too short
  const Found found = extract(edgels, {peak_at(rho, theta)});
  REQUIRE(found.segments.size() == 2);
  CHECK(found.segments[0].t_min == doctest::Approx(-100).epsilon(0.01));
  CHECK(found.segments[0].t_max == doctest::Approx(-20).epsilon(0.05));
  CHECK(found.segments[1].t_max == doctest::Approx(40).epsilon(0.05));
  CHECK(found.segments[0].support > found.segments[1].support);

  std::vector<rvdnav_edgel> sparse;
  for (double t = 0.0; t < 80.0; t += 3.0) add_noisy(sparse, {rho, theta, t, t}, random, 0.2);
  CHECK(extract(sparse, {peak_at(rho, theta)}).segments.empty());
}

TEST_CASE("the two sides of a thin line are two segments of opposite polarity") {
  plain::Random random(42);
  std::vector<rvdnav_edgel> edgels;
  add_noisy(edgels, {50.0, 80.0, -30.0, 50.0, false}, random, 0.3);
  add_noisy(edgels, {51.5, 80.0, -30.0, 50.0, true}, random, 0.3);
  const Found found = extract(edgels, {peak_at(50.0, 80.0), peak_at(51.5, 80.0)});
  REQUIRE(found.segments.size() == 2);
  CHECK_FALSE(same_polarity(found.segments[0], found.segments[1]));
  for (const rvdnav_segment& s : found.segments)
    CHECK(s.rho == doctest::Approx(s.polarity > 0 ? 50.0 : 51.5).epsilon(0.004));
}

TEST_CASE("a run found from several peaks is kept once") {
  plain::Random random(43);
  std::vector<rvdnav_edgel> edgels;
  add_noisy(edgels, {-70.0, 44.0, -60.0, 60.0}, random, 0.3);
  const Found found =
      extract(edgels, {peak_at(-70.0, 44.0), peak_at(-70.9, 44.4), peak_at(-69.2, 43.6), peak_at(-70.0, 44.9)});
  CHECK(found.segments.size() == 1);
  CHECK(found.total == 1);
}

TEST_CASE("a full array keeps its place and the total tells of the rest") {
  plain::Random random(44);
  std::vector<rvdnav_edgel> edgels;
  std::vector<rvdnav_peak> peaks;
  for (int i = 0; i < 6; ++i) {
    add_noisy(edgels, {-100.0 + 30.0 * i, 5.0, -30.0, 30.0 + 5.0 * i}, random, 0.2);
    peaks.push_back(peak_at(-100.0 + 30.0 * i, 5.0));
  }
  const Found found = extract(edgels, peaks, 4);
  CHECK(found.segments.size() == 4);
  CHECK(found.total == 6);
  CHECK(std::is_sorted(found.segments.begin(), found.segments.end(),
                       [](const rvdnav_segment& a, const rvdnav_segment& b) { return a.support > b.support; }));
  CHECK(extract({}, peaks).segments.empty());
  CHECK(extract(edgels, {}).segments.empty());
}

TEST_CASE("polarities compare across the end of the theta range") {
  const rvdnav_segment a = {10.0, plain::radians(134.5), 0.0, 50.0, 1, 50, 0.1};
  const rvdnav_segment b = {-10.0, plain::radians(-44.5), -50.0, 0.0, -1, 50, 0.1};
  rvdnav_segment c = b;
  c.polarity = 1;
  CHECK(same_polarity(a, b));
  CHECK_FALSE(same_polarity(a, c));
}
