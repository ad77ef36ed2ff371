#include "bars.hpp"

#include <algorithm>
#include <cmath>

#include "line2.hpp"
#include "lines.hpp"
#include "math/elementary.hpp"

namespace rvdnav {
namespace {

constexpr double kMaxAngle = 0.10;       // between the two sides, radians: perspective and fit noise
constexpr double kMinOverlap = 0.5;      // of the shorter side
constexpr double kMinSlenderness = 2.0;  // seen length over width

bool make_bar(const rvdnav_segment* segments, int32_t i, int32_t j, const BarLimits& limits, rvdnav_bar* bar) {
  const rvdnav_segment& a = segments[i];
  const rvdnav_segment& b = segments[j];
  const double turn = line_angle_difference(b.theta, a.theta);
  if (std::abs(turn) > kMaxAngle) return false;
  const Line2 la = Line2::from_angle(a.rho, a.theta);
  Line2 lb = Line2::from_angle(b.rho, b.theta);
  double b_min = b.t_min;
  double b_max = b.t_max;
  if (la.normal.dot(lb.normal) < 0.0) {  // across the end of the theta range
    lb = {-lb.normal, -lb.rho};
    b_min = -b.t_max;
    b_max = -b.t_min;
  }
  // b's ends along a
  const double p = la.direction().dot(lb.at(b_min));
  const double q = la.direction().dot(lb.at(b_max));
  const double low = std::max(a.t_min, p);
  const double high = std::min(a.t_max, q);
  const double overlap = high - low;
  if (overlap < kMinOverlap * std::min(a.t_max - a.t_min, b.t_max - b.t_min)) return false;
  const Eigen::Vector2d middle = la.at(0.5 * (low + high));
  const double width = -lb.distance(middle);  // positive when b has the larger rho seen along a's normal
  if (std::abs(width) < limits.min_width || std::abs(width) > limits.max_width) return false;
  if (overlap < kMinSlenderness * std::abs(width)) return false;
  const Eigen::Vector2d normal = (la.normal + lb.normal).normalized();
  bool flipped = false;
  bar->theta = normalized_theta(math::atan2(normal.y(), normal.x()), &flipped);
  const Line2 axis = Line2::from_angle(0.0, bar->theta);
  const Eigen::Vector2d centre = middle + 0.5 * width * la.normal;
  bar->rho = axis.normal.dot(centre);
  bar->width = std::abs(width);
  double ends[4] = {axis.direction().dot(la.at(a.t_min)), axis.direction().dot(la.at(a.t_max)),
                    axis.direction().dot(lb.at(b_min)), axis.direction().dot(lb.at(b_max))};
  bar->t_min = *std::min_element(ends, ends + 4);
  bar->t_max = *std::max_element(ends, ends + 4);
  if (bar->t_max - bar->t_min > limits.max_slenderness * bar->width) return false;
  const bool ordered = axis.normal.dot(la.at(0.5 * (low + high))) < bar->rho;
  bar->segment[0] = ordered ? i : j;
  bar->segment[1] = ordered ? j : i;
  return true;
}

// Rank of a bar: opposite polarities first, then the weaker side's support.
uint32_t rank(const rvdnav_segment* segments, const rvdnav_bar& bar) {
  const rvdnav_segment& a = segments[bar.segment[0]];
  const rvdnav_segment& b = segments[bar.segment[1]];
  return (same_polarity(a, b) ? 0U : 1U << 20) + std::min(a.support, b.support);
}

}  // namespace

uint32_t find_bars(const rvdnav_segment* segments, uint32_t segment_count, const BarLimits& limits, rvdnav_bar* bars,
                   uint32_t capacity, uint32_t* total) {
  uint32_t count = 0;
  *total = 0;
  const auto better = [segments](const rvdnav_bar& x, const rvdnav_bar& y) {
    const uint32_t rx = rank(segments, x);
    const uint32_t ry = rank(segments, y);
    if (rx != ry) return rx > ry;
    if (x.segment[0] != y.segment[0]) return x.segment[0] < y.segment[0];
    return x.segment[1] < y.segment[1];
  };
  // A heap with the worst bar on top keeps the best ones within the capacity.
  for (uint32_t i = 0; i < segment_count; ++i) {
    for (uint32_t j = i + 1; j < segment_count; ++j) {
      rvdnav_bar bar = {};
      if (!make_bar(segments, static_cast<int32_t>(i), static_cast<int32_t>(j), limits, &bar)) continue;
      ++*total;
      if (count < capacity) {
        bars[count++] = bar;
        std::push_heap(bars, bars + count, better);
      } else if (capacity > 0 && better(bar, bars[0])) {
        std::pop_heap(bars, bars + count, better);
        bars[count - 1] = bar;
        std::push_heap(bars, bars + count, better);
      }
    }
  }
  std::sort_heap(bars, bars + count, better);
  return count;
}

}  // namespace rvdnav
