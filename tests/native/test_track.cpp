#include <doctest/doctest.h>

#include <cmath>
#include <vector>

#include "edgel_lines.hpp"
#include "track.hpp"

using namespace rvdnav;

namespace {

rvdnav_window window_at(const plain::Line& line, double d_rho, double d_theta_deg, double half_rho,
                        double half_theta_deg) {
  return {0,
          0,
          line.rho + d_rho,
          plain::radians(line.theta_deg + d_theta_deg),
          half_rho,
          plain::radians(half_theta_deg),
          line.t_min,
          line.t_max};
}

rvdnav_peak track(const std::vector<rvdnav_edgel>& edgels, const rvdnav_window& window, int32_t spread = 4) {
  static std::vector<uint16_t> votes(track_votes(kTrackMinShear));
  const TrackScratch scratch = {kTrackMinShear, votes.data()};
  rvdnav_peak peak = {1, 2, 3};
  hough_track(edgels.data(), static_cast<uint32_t>(edgels.size()), spread, &window, 1, scratch, &peak);
  return peak;
}

std::vector<rvdnav_edgel> edgels_of(const std::vector<plain::Line>& lines, int clutter = 0) {
  plain::Random random(14);
  std::vector<rvdnav_edgel> edgels;
  for (const plain::Line& line : lines) plain::add_line(edgels, line, random);
  plain::add_clutter(edgels, clutter, random);
  return edgels;
}

double off(const plain::Line& line, const rvdnav_peak& peak) {
  return plain::distance_at_ends(line, plain::rho_of(peak), plain::theta_of(peak));
}

}  // namespace

TEST_CASE("a line in its window is found, near the centre and far along its line") {
  plain::Random random(15);
  double sum = 0;
  int count = 0;
  for (int i = 0; i < 200; ++i) {
    const double length = random.real(35.0, 250.0), t = random.real(-200.0, 200.0);
    const plain::Line line = {random.real(-250.0, 250.0), random.real(-45.0, 134.9), t - length / 2, t + length / 2,
                              i % 2 == 0};
    const rvdnav_window window = window_at(line, random.real(-4, 4), random.real(-2, 2), 6.0, 3.0);
    const rvdnav_peak peak = track(edgels_of({line}, 3000), window);
    REQUIRE(peak.votes > 0.4 * length);
    REQUIRE(peak.votes <= length + 2);
    REQUIRE(off(line, peak) < 1.6);
    sum += off(line, peak);
    ++count;
  }
  CHECK(sum / count < 0.5);
}

TEST_CASE("what is not in the window is not found") {
  const plain::Line line = {50.0, 20.3, -60.0, 60.0};
  const std::vector<rvdnav_edgel> edgels = edgels_of({line});
  CHECK(track(edgels, window_at(line, 0, 0, 5, 2)).votes > 0);
  // Just outside, by each side: no flank of it is reported.
  for (double side : {-1.0, 1.0}) {
    for (double d : {6.5, 7.0, 8.0, 12.0}) CHECK(track(edgels, window_at(line, side * d, 0, 5, 2)).votes == 0);
    for (double d : {3.5, 5.0, 9.0}) CHECK(track(edgels, window_at(line, 0, side * d, 5, 2)).votes == 0);
  }
  CHECK(track({}, window_at(line, 0, 0, 5, 2)).votes == 0);
  CHECK(track(edgels_of({}, 4000), window_at(line, 0, 0, 5, 2)).votes == 0);
}

TEST_CASE("a lost window is answered by its middle") {
  const rvdnav_peak peak = track({}, {0, 0, -31.0, plain::radians(77.0), 5.0, 0.05, -20.0, 20.0});
  CHECK(peak.votes == 0);
  CHECK(std::fabs(plain::rho_of(peak) + 31.0) <= 0.25);
  CHECK(std::fabs(peak.theta_q8 / 256.0 - 77.0) <= 0.25);
}

TEST_CASE("a stronger line outside the window does not hide the one inside") {
  const plain::Line faint = {40.0, 88.0, -25.0, 25.0}, strong = {46.0, 88.0, -150.0, 150.0};
  const rvdnav_peak peak = track(edgels_of({faint, strong, strong}), window_at(faint, 1.0, 0.5, 4.0, 3.0));
  CHECK(peak.votes > 20);
  CHECK(off(faint, peak) < 1.2);
}

TEST_CASE("edgels beside the expected extent or against the gradient do not vote") {
  const plain::Line expected = {10.0, 60.0, -30.0, 30.0};
  const plain::Line elsewhere = {10.0, 60.0, 60.0, 140.0};
  CHECK(track(edgels_of({elsewhere}), window_at(expected, 0, 0, 5, 2)).votes == 0);
  std::vector<rvdnav_edgel> crossed = edgels_of({expected});
  for (rvdnav_edgel& e : crossed) e.direction = static_cast<uint8_t>(e.direction + 30);
  CHECK(track(crossed, window_at(expected, 0, 0, 5, 2)).votes == 0);
  for (rvdnav_edgel& e : crossed) e.direction = static_cast<uint8_t>(e.direction - 30 + 128);
  CHECK(track(crossed, window_at(expected, 0, 0, 5, 2)).votes > 30);
}

TEST_CASE("windows across the wrap and with theta of another half turn") {
  const plain::Line line = {70.0, -44.7, -30.0, 50.0};
  const std::vector<rvdnav_edgel> edgels = edgels_of({line}, 1000);
  for (double degrees : {-46.0, -44.0}) {
    const rvdnav_window window = {0, 0, 71.0, plain::radians(degrees), 5.0, plain::radians(3.0), -30.0, 50.0};
    const rvdnav_peak peak = track(edgels, window);
    CHECK(peak.votes > 40);
    CHECK(off(line, peak) < 1.2);
  }
  // The same line as seen from the other side: rho and t negated.
  const rvdnav_window turned = {0, 0, -71.0, plain::radians(134.0), 5.0, plain::radians(3.0), -50.0, 30.0};
  const rvdnav_peak peak = track(edgels, turned);
  CHECK(peak.votes > 40);
  CHECK(off(line, peak) < 1.2);
  CHECK(peak.theta_q8 >= -45 * 256);
  CHECK(peak.theta_q8 < 135 * 256);
}

TEST_CASE("windows of any size stay inside the scratch memory") {
  plain::Random random(16);
  const std::vector<rvdnav_edgel> edgels = edgels_of({{0.0, 0.0, -300.0, 300.0}}, 2000);
  for (int i = 0; i < 60; ++i) {
    const double t = random.real(-3000.0, 3000.0);
    track(edgels,
          {0, 0, random.real(-3000.0, 3000.0), random.real(-7.0, 7.0), random.real(0.0, 500.0), random.real(0.0, 4.0),
           t, t + random.real(0.0, 2000.0)},
          random.between(0, 45));
  }
  const rvdnav_peak sharp = track(edgels, {0, 0, 0.1, 0.001, 0.0, 0.0, -300.0, 300.0});
  CHECK(sharp.votes > 100);
}
