#include "lines.hpp"

#include <algorithm>
#include <cmath>

#include "line2.hpp"
#include "math/elementary.hpp"

namespace rvdnav {
namespace {

constexpr double kPeakBand = 2.0;       // half-width of the strip gathered around a peak, pixels
constexpr double kFitBand = 1.2;        // half-width around the fitted line, pixels
constexpr int32_t kDirectionSlack = 8;  // levels of 1/256 turn (11 degrees) between an edgel and its line
constexpr uint32_t kMinSupport = 8;
constexpr double kMinDensity = 0.6;  // edgels per pixel of length

// Fixed point for what need not be exact: unit vectors in 2^-20, so that products with coordinates are in 2^-25 pixels.
constexpr double kUnitScale = 1 << 20;
constexpr double kProductScale = 1 << 25;
// By which such a distance may be off, pixels: rectified coordinates stay below 2^13, each rounding is half a unit.
constexpr double kProductError = 1.0 / 64.0;

struct Strip {
  Line2 line;
  int32_t direction;  // level of the gradient that belongs to this polarity
};

double coordinate(int32_t q5) { return q5 * (1.0 / 32.0); }

int32_t level_of(double angle) {
  const double turns = angle / (2.0 * kPi);
  return static_cast<int32_t>(std::lround((turns - std::floor(turns)) * int32_t{RVDNAV_DIRECTION_LEVELS})) &
         (RVDNAV_DIRECTION_LEVELS - 1);
}

void sort_by_direction(const rvdnav_edgel* edgels, uint32_t count, LineScratch& scratch) {
  constexpr int32_t kLevels = RVDNAV_DIRECTION_LEVELS / kDirectionBuckets;
  uint32_t* start = scratch.bucket_start;
  std::fill(start, start + kDirectionBuckets + 1, 0U);
  for (uint32_t i = 0; i < count; ++i) ++start[edgels[i].direction / kLevels + 1];
  for (int32_t b = 0; b < kDirectionBuckets; ++b) start[b + 1] += start[b];
  uint32_t next[kDirectionBuckets];
  std::copy(start, start + kDirectionBuckets, next);
  for (uint32_t i = 0; i < count; ++i) scratch.order[next[edgels[i].direction / kLevels]++] = i;
}

// Edgels within band of the strip's line that point its way, sorted along it.
uint32_t gather(const rvdnav_edgel* edgels, const Strip& strip, double band, LineScratch& scratch) {
  constexpr int32_t kLevels = RVDNAV_DIRECTION_LEVELS / kDirectionBuckets;
  const int32_t first = (strip.direction - kDirectionSlack + RVDNAV_DIRECTION_LEVELS) / kLevels;
  const int32_t last = (strip.direction + kDirectionSlack + RVDNAV_DIRECTION_LEVELS) / kLevels;
  const double c = strip.line.normal.x();
  const double s = strip.line.normal.y();
  // Most edgels are far from the line: they are told in integers.
  const int64_t c_q20 = std::lround(c * kUnitScale), s_q20 = std::lround(s * kUnitScale);
  const int64_t rho_q25 = static_cast<int64_t>(strip.line.rho * kProductScale);
  const int64_t near_q25 = static_cast<int64_t>((band + kProductError) * kProductScale);
  uint32_t n = 0;
  for (int32_t b = first; b <= last; ++b) {
    const int32_t bucket = b % kDirectionBuckets;
    for (uint32_t k = scratch.bucket_start[bucket]; k < scratch.bucket_start[bucket + 1]; ++k) {
      const rvdnav_edgel& e = edgels[scratch.order[k]];
      const int64_t distance_q25 = e.x_q5 * c_q20 + e.y_q5 * s_q20 - rho_q25;
      if (distance_q25 > near_q25 || distance_q25 < -near_q25) continue;
      const double x = coordinate(e.x_q5);
      const double y = coordinate(e.y_q5);
      if (std::abs(x * c + y * s - strip.line.rho) > band) continue;
      scratch.members[n++] = {static_cast<float>(y * c - x * s), scratch.order[k]};
    }
  }
  const auto before = [](const LineScratch::Member& a, const LineScratch::Member& b) {
    return a.t != b.t ? a.t < b.t : a.edgel < b.edgel;
  };
  // By a heap: std::sort calls itself.
  std::make_heap(scratch.members, scratch.members + n, before);
  std::sort_heap(scratch.members, scratch.members + n, before);
  return n;
}

// Total least squares through members [begin, end), without those farther than band from the line of the last round.
bool fit(const rvdnav_edgel* edgels, const LineScratch& scratch, uint32_t begin, uint32_t end, double band, Line2* line,
         rvdnav_segment* out) {
  double n = 0, sx = 0, sy = 0, sxx = 0, sxy = 0, syy = 0;
  for (uint32_t i = begin; i < end; ++i) {
    const rvdnav_edgel& e = edgels[scratch.members[i].edgel];
    const Eigen::Vector2d p(coordinate(e.x_q5), coordinate(e.y_q5));
    if (std::abs(line->distance(p)) > band) continue;
    n += 1;
    sx += p.x();
    sy += p.y();
    sxx += p.x() * p.x();
    sxy += p.x() * p.y();
    syy += p.y() * p.y();
  }
  if (n < kMinSupport) return false;
  const double mx = sx / n;
  const double my = sy / n;
  const double cxx = sxx / n - mx * mx;
  const double cxy = sxy / n - mx * my;
  const double cyy = syy / n - my * my;
  // The direction of largest spread is (cos a, sin a) with tan 2a = 2 cxy / (cxx - cyy); the normal is 90 degrees on.
  double angle = 0.5 * math::atan2(2.0 * cxy, cxx - cyy) + 0.5 * kPi;
  bool flipped = false;
  angle = normalized_theta(angle, &flipped);
  Line2 fitted = Line2::from_angle(0.0, angle);
  fitted.rho = fitted.normal.dot(Eigen::Vector2d(mx, my));
  const double spread = 0.5 * (cxx + cyy - std::sqrt((cxx - cyy) * (cxx - cyy) + 4.0 * cxy * cxy));
  *line = fitted;
  out->rho = fitted.rho;
  out->theta = angle;
  out->support = static_cast<uint32_t>(n);
  out->rms = std::sqrt(std::max(spread, 0.0));
  out->t_min = 1e9;
  out->t_max = -1e9;
  for (uint32_t i = begin; i < end; ++i) {
    const rvdnav_edgel& e = edgels[scratch.members[i].edgel];
    const Eigen::Vector2d p(coordinate(e.x_q5), coordinate(e.y_q5));
    if (std::abs(fitted.distance(p)) > band) continue;
    const double t = fitted.direction().dot(p);
    out->t_min = std::min(out->t_min, t);
    out->t_max = std::max(out->t_max, t);
  }
  return true;
}

// Most of one segment lies on another of the same polarity.
bool same_run(const rvdnav_segment& a, const rvdnav_segment& b) {
  if (std::abs(line_angle_difference(a.theta, b.theta)) > 0.07 || !same_polarity(a, b)) return false;
  const Line2 base = Line2::from_angle(a.rho, a.theta);
  const Line2 other = Line2::from_angle(b.rho, b.theta);
  const Eigen::Vector2d p = other.at(b.t_min);
  const Eigen::Vector2d q = other.at(b.t_max);
  if (std::abs(base.distance(p)) > 1.5 || std::abs(base.distance(q)) > 1.5) return false;
  const double tp = base.direction().dot(p);
  const double tq = base.direction().dot(q);
  const double low = std::max(std::min(tp, tq), a.t_min);
  const double high = std::min(std::max(tp, tq), a.t_max);
  return high - low > 0.5 * std::min(b.t_max - b.t_min, a.t_max - a.t_min);
}

class SegmentList {
 public:
  SegmentList(rvdnav_segment* segments, uint32_t capacity) : segments_(segments), capacity_(capacity) {}

  // Keeps the better supported one of two that are the same run.
  void add(const rvdnav_segment& s) {
    for (uint32_t i = 0; i < count_; ++i) {
      if (!same_run(segments_[i], s)) continue;
      if (segments_[i].support < s.support) segments_[i] = s;
      return;
    }
    ++total_;
    if (count_ < capacity_) segments_[count_++] = s;
  }

  void sort() {
    const auto before = [](const rvdnav_segment& a, const rvdnav_segment& b) {
      if (a.support != b.support) return a.support > b.support;
      if (a.rho != b.rho) return a.rho < b.rho;
      return a.t_min < b.t_min;
    };
    std::make_heap(segments_, segments_ + count_, before);
    std::sort_heap(segments_, segments_ + count_, before);
  }

  uint32_t count() const { return count_; }
  uint32_t total() const { return total_; }

 private:
  rvdnav_segment* segments_;
  uint32_t capacity_;
  uint32_t count_ = 0;
  uint32_t total_ = 0;
};

}  // namespace

bool same_polarity(const rvdnav_segment& a, const rvdnav_segment& b) {
  // Normals of near-parallel lines oppose each other only across the end of the theta range.
  const bool normals_agree = std::abs(a.theta - b.theta) < 0.5 * kPi;
  return normals_agree == (a.polarity == b.polarity);
}

uint32_t extract_segments(const rvdnav_edgel* edgels, uint32_t edgel_count, const rvdnav_peak* peaks,
                          uint32_t peak_count, const SegmentLimits& limits, LineScratch& scratch,
                          rvdnav_segment* segments, uint32_t capacity, uint32_t* total) {
  sort_by_direction(edgels, edgel_count, scratch);
  SegmentList list(segments, capacity);
  for (uint32_t k = 0; k < peak_count; ++k) {
    const double theta = peaks[k].theta_q8 * (kPi / (180.0 * 256.0));
    for (int32_t polarity = 1; polarity >= -1; polarity -= 2) {
      Strip strip = {Line2::from_angle(peaks[k].rho_q8 / 256.0, theta), level_of(polarity > 0 ? theta : theta + kPi)};
      const uint32_t n = gather(edgels, strip, kPeakBand, scratch);
      for (uint32_t begin = 0, end = 0; begin < n; begin = end) {
        end = begin + 1;
        while (end < n && scratch.members[end].t - scratch.members[end - 1].t <= limits.max_gap) ++end;
        if (end - begin < kMinSupport || scratch.members[end - 1].t - scratch.members[begin].t < limits.min_length)
          continue;
        rvdnav_segment s = {};
        Line2 line = strip.line;
        bool good = fit(edgels, scratch, begin, end, kPeakBand, &line, &s);
        for (int32_t round = 0; good && round < 2; ++round)
          good = fit(edgels, scratch, begin, end, kFitBand, &line, &s);
        if (!good) continue;
        const double length = s.t_max - s.t_min;
        if (length < limits.min_length || s.support < kMinDensity * length) continue;
        // The normal may have turned over against the peak's across the end of the theta range.
        s.polarity = line.normal.dot(strip.line.normal) > 0.0 ? polarity : -polarity;
        list.add(s);
      }
    }
  }
  list.sort();
  *total = list.total();
  return list.count();
}

}  // namespace rvdnav
