#include <doctest/doctest.h>

#include <cmath>
#include <vector>

#include "bars.hpp"
#include "bracket_views.hpp"

using namespace rvdnav;
using views::segment_between;
using views::Vector2d;

namespace {

constexpr BarLimits kLimits = {2.0, 20.0, 70.0};

struct Found {
  std::vector<rvdnav_bar> bars;
  uint32_t total;
};

Found find(const std::vector<rvdnav_segment>& segments, uint32_t capacity = 64) {
  Found found = {std::vector<rvdnav_bar>(capacity), 0};
  const uint32_t n = find_bars(segments.data(), static_cast<uint32_t>(segments.size()), kLimits, found.bars.data(),
                               capacity, &found.total);
  found.bars.resize(n);
  return found;
}

// The two sides of a bright bar about the line from a to b.
std::vector<rvdnav_segment> sides(const Vector2d& a, const Vector2d& b, double width) {
  const Vector2d d = (b - a).normalized();
  const Vector2d half = 0.5 * width * Vector2d(-d.y(), d.x());
  const Vector2d middle = 0.5 * (a + b);
  return {segment_between(a - half, b - half, middle), segment_between(a + half, b + half, middle)};
}

}  // namespace

TEST_CASE("two sides make a bar, in every direction") {
  plain::Random random(50);
  for (int i = 0; i < 200; ++i) {
    const Vector2d a(random.real(-200, 200), random.real(-200, 200));
    const double angle = random.real(-M_PI, M_PI), length = random.real(50, 200), width = random.real(3, 19);
    const Vector2d b = a + length * Vector2d(std::cos(angle), std::sin(angle));
    const std::vector<rvdnav_segment> segments = sides(a, b, width);
    const Found found = find(segments);
    REQUIRE(found.bars.size() == 1);
    const rvdnav_bar& bar = found.bars[0];
    const Vector2d n(std::cos(bar.theta), std::sin(bar.theta));
    const Vector2d d(-n.y(), n.x());
    CHECK(bar.width == doctest::Approx(width));
    CHECK(n.dot(a) == doctest::Approx(bar.rho));
    CHECK(n.dot(b) == doctest::Approx(bar.rho));
    CHECK(bar.t_min == doctest::Approx(std::min(d.dot(a), d.dot(b))));
    CHECK(bar.t_max == doctest::Approx(std::max(d.dot(a), d.dot(b))));
    // The second segment lies towards growing rho of the bar.
    const auto middle_of = [&](int32_t k) {
      const rvdnav_segment& s = segments[static_cast<size_t>(k)];
      const Line2 line = Line2::from_angle(s.rho, s.theta);
      return line.at(0.5 * (s.t_min + s.t_max));
    };
    CHECK(n.dot(middle_of(bar.segment[0])) < bar.rho);
    CHECK(n.dot(middle_of(bar.segment[1])) > bar.rho);
  }
}

TEST_CASE("what is too wide, too narrow, crossed or side by side only at the ends is no bar") {
  const Vector2d a(0, 0), b(100, 0);
  CHECK(find(sides(a, b, 1.5)).bars.empty());
  CHECK(find(sides(a, b, 21.0)).bars.empty());
  CHECK(find(sides(a, {30, 0}, 18.0)).bars.empty());  // as wide as long
  const rvdnav_segment base = segment_between(a, b, {50, 5});
  CHECK(find(sides(a, {155, 0}, 2.2)).bars.empty());  // longer than any bar of that width
  CHECK(find({base, segment_between({0, 4}, {100, 20}, {50, 5})}).bars.empty());
  CHECK(find({base, segment_between({70, 8}, {170, 8}, {50, 5})}).bars.empty());
  CHECK(find({base, segment_between({40, 8}, {140, 8}, {50, 5})}).bars.size() == 1);
  CHECK(find({}).bars.empty());
}

TEST_CASE("opposite polarities rank before equal ones, then the longer bar") {
  std::vector<rvdnav_segment> segments = sides({0, 0}, {60, 0}, 8);
  const std::vector<rvdnav_segment> longer = sides({0, 100}, {90, 100}, 8);
  segments.insert(segments.end(), longer.begin(), longer.end());
  // A staircase: twice from dark to bright in one direction.
  segments.push_back(segment_between({0, -100}, {150, -100}, {0, -96}));
  segments.push_back(segment_between({0, -90}, {150, -90}, {0, -86}));
  const Found found = find(segments);
  REQUIRE(found.bars.size() == 3);
  CHECK(found.bars[0].segment[0] + found.bars[0].segment[1] == 2 + 3);
  CHECK(found.bars[1].segment[0] + found.bars[1].segment[1] == 0 + 1);
  CHECK(found.bars[2].segment[0] + found.bars[2].segment[1] == 4 + 5);
  const Found best = find(segments, 2);
  REQUIRE(best.bars.size() == 2);
  CHECK(best.total == 3);
  CHECK(best.bars[0].rho == found.bars[0].rho);
  CHECK(best.bars[1].rho == found.bars[1].rho);
}

TEST_CASE("sides whose angles lie at both ends of the theta range make a bar") {
  const Vector2d d(std::sqrt(0.5), std::sqrt(0.5));
  const Vector2d n(-d.y(), d.x());
  // Normals along (1, -1), one turned a little to each side.
  const std::vector<rvdnav_segment> segments = {segment_between(20.0 * d - 5.0 * n, 100.0 * d - 4.0 * n, 60.0 * d),
                                                segment_between(20.0 * d + 5.0 * n, 100.0 * d + 4.0 * n, 60.0 * d)};
  REQUIRE(std::abs(segments[0].theta - segments[1].theta) > 3.0);
  const Found found = find(segments);
  REQUIRE(found.bars.size() == 1);
  CHECK(found.bars[0].width == doctest::Approx(9.0).epsilon(0.01));
  CHECK(std::abs(found.bars[0].rho) < 0.01);
  CHECK(found.bars[0].t_max - found.bars[0].t_min == doctest::Approx(80.0).epsilon(0.01));
}
