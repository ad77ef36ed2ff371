#include "epipolar.hpp"

#include <algorithm>
#include <cmath>

#include "lens.hpp"

namespace rvdnav {
namespace {

constexpr int32_t kNodeStep = 8;       // pixels between exact lens evaluations along a row
constexpr double kMinDeviation = 1.0;  // grey levels: a window without structure matches everything
constexpr int32_t kRivalDistance = 3;  // disparities from the best where a rival begins
constexpr int16_t kOutside = -1;

// Grey value in Q4 by integer bilinear interpolation at a raw position in Q8.
int16_t grey_q4(const GreyView& image, int32_t u_q8, int32_t v_q8) {
  if (u_q8 < 0 || v_q8 < 0) return kOutside;
  const int32_t x = u_q8 >> 8;
  const int32_t y = v_q8 >> 8;
  if (x >= image.width - 1 || y >= image.height - 1) return kOutside;
  const int32_t a = u_q8 & 255;
  const int32_t b = v_q8 & 255;
  const uint8_t* p = image.row(y) + x;
  const uint8_t* q = p + image.stride;
  const int32_t top = (256 - a) * p[0] + a * p[1];
  const int32_t bottom = (256 - a) * q[0] + a * q[1];
  return static_cast<int16_t>(((256 - b) * top + b * bottom + (1 << 11)) >> 12);
}

// n grey values along a rectified row from (x, y) on.  The lens is evaluated every kNodeStep pixels.
void sample_row(const rvdnav_rig& rig, int32_t camera, const GreyView& image, double x, double y, int32_t n,
                int16_t* out) {
  double u = 0.0;
  double v = 0.0;
  rect_to_raw(rig, camera, x, y, &u, &v);
  for (int32_t begin = 0; begin < n; begin += kNodeStep) {
    double u1 = 0.0;
    double v1 = 0.0;
    rect_to_raw(rig, camera, x + begin + kNodeStep, y, &u1, &v1);
    for (int32_t i = begin; i < std::min(begin + kNodeStep, n); ++i) {
      const double w = static_cast<double>(i - begin) / kNodeStep;
      const double ui = u + w * (u1 - u);
      const double vi = v + w * (v1 - v);
      const bool inside = ui >= 0.0 && vi >= 0.0 && ui < image.width && vi < image.height;
      out[i] = inside ? grey_q4(image, static_cast<int32_t>(ui * 256.0 + 0.5), static_cast<int32_t>(vi * 256.0 + 0.5))
                      : kOutside;
    }
    u = u1;
    v = v1;
  }
}

struct Patch {
  int32_t size;  // of a side
  int64_t sum;
  double deviation;  // square root of the sum of squared deviations, Q4
};

// The reference window around a point; false when it leaves the image or has no structure.
bool sample_patch(const rvdnav_config& config, const rvdnav_rig& rig, int32_t camera, const GreyView& image, double x,
                  double y, int16_t* window, Patch* patch) {
  const int32_t h = config.match_half_window;
  const int32_t size = 2 * h + 1;
  int64_t sum = 0;
  int64_t square = 0;
  for (int32_t r = 0; r < size; ++r) {
    int16_t* row = window + r * size;
    sample_row(rig, camera, image, x - h, y + (r - h), size, row);
    for (int32_t c = 0; c < size; ++c) {
      if (row[c] == kOutside) return false;
      sum += row[c];
      square += row[c] * row[c];
    }
  }
  const double n = static_cast<double>(size) * size;
  const double variance = static_cast<double>(square) - static_cast<double>(sum) * static_cast<double>(sum) / n;
  *patch = {size, sum, std::sqrt(std::max(variance, 0.0))};
  return patch->deviation >= kMinDeviation * 16.0 * std::sqrt(n);
}

// Correlation of the reference window with the band at a row and column; -1 where the band leaves the image.
double correlation(const int16_t* window, const Patch& patch, const int16_t* band, int32_t columns) {
  int64_t sum = 0;
  int64_t square = 0;
  int64_t cross = 0;
  for (int32_t r = 0; r < patch.size; ++r) {
    const int16_t* a = window + r * patch.size;
    const int16_t* b = band + r * columns;
    int32_t row_sum = 0;
    int64_t row_square = 0;
    int64_t row_cross = 0;
    for (int32_t c = 0; c < patch.size; ++c) {
      if (b[c] == kOutside) return -1.0;
      row_sum += b[c];
      row_square += b[c] * b[c];
      row_cross += a[c] * b[c];
    }
    sum += row_sum;
    square += row_square;
    cross += row_cross;
  }
  const double n = static_cast<double>(patch.size) * patch.size;
  const double mean = static_cast<double>(sum) / n;
  const double variance = static_cast<double>(square) - static_cast<double>(sum) * mean;
  if (variance < kMinDeviation * kMinDeviation * 256.0 * n) return -1.0;
  return (static_cast<double>(cross) - static_cast<double>(patch.sum) * mean) / (patch.deviation * std::sqrt(variance));
}

struct Search {
  double disparity, score, rival;
};

// Searches the other view's rows for the window around (x, y) of one view; disparity = x_left - x_right.
bool search_row(const rvdnav_config& config, const rvdnav_rig& rig, int32_t from_camera, const GreyView& from,
                const GreyView& to, const Disparities& disparities, double x, double y, const MatchScratch& scratch,
                Search* out) {
  Patch patch;
  if (!sample_patch(config, rig, from_camera, from, x, y, scratch.window, &patch)) return false;
  const int32_t first = disparities.first;
  const int32_t n = disparities.count;
  const int32_t last = first + n - 1;
  const int32_t h = config.match_half_window;
  const int32_t tolerance = config.match_row_tolerance;
  // In the right view the match lies at x - d, in the left one at x + d: the band starts at its smallest x.
  const double start = from_camera == 0 ? x - last - h : x + first - h;
  const int32_t columns = n + 2 * h;
  const int32_t rows = 2 * (h + tolerance) + 1;
  for (int32_t r = 0; r < rows; ++r)
    sample_row(rig, 1 - from_camera, to, start, y + (r - h - tolerance), columns, scratch.band + r * columns);

  int32_t best = -1;
  int32_t best_shift = 0;
  double best_score = -1.0;
  for (int32_t i = 0; i < n; ++i) {
    double score = -1.0;
    for (int32_t shift = 0; shift <= 2 * tolerance; ++shift) {
      const double s = correlation(scratch.window, patch, scratch.band + shift * columns + i, columns);
      if (s <= score) continue;
      score = s;
      if (s > best_score) best_shift = shift;
    }
    scratch.score[i] = static_cast<float>(score);
    if (score <= best_score) continue;
    best_score = score;
    best = i;
  }
  if (best <= 0 || best >= n - 1) return false;
  double rival = -1.0;
  for (int32_t i = 0; i < n; ++i) {
    if (std::abs(i - best) >= kRivalDistance) rival = std::max<double>(rival, scratch.score[i]);
  }
  // Sub-pixel by a parabola through the best row's neighbours.
  const int16_t* row = scratch.band + best_shift * columns + best;
  const double before = correlation(scratch.window, patch, row - 1, columns);
  const double after = correlation(scratch.window, patch, row + 1, columns);
  const double curvature = before - 2.0 * best_score + after;
  const double shift = curvature < -1e-12 ? std::clamp(0.5 * (before - after) / curvature, -0.5, 0.5) : 0.0;
  const double column = best + shift;
  out->disparity = from_camera == 0 ? last - column : first + column;
  out->score = best_score;
  out->rival = rival;
  return true;
}

}  // namespace

Disparities allowed_disparities(const rvdnav_config& config, const rvdnav_rig& rig, double reach) {
  // Between points of both images there are none beyond twice the reach.
  const auto disparity = [&](double range) {
    return static_cast<int32_t>(std::min(rig.focal_rect * rig.baseline / range, 2.0 * reach));
  };
  const int32_t first = disparity(config.range_max);
  return {first, disparity(config.range_min) + 2 - first};
}

void correlate_rows(const rvdnav_config& config, const rvdnav_rig& rig, const Disparities& disparities,
                    const GreyView& left, const GreyView& right, const MatchScratch& scratch, rvdnav_match* matches,
                    uint32_t count) {
  const double min_score = config.match_min_score_q8 / 256.0;
  const double uniqueness = config.match_uniqueness_q8 / 256.0;
  const double consistency = config.match_consistency_q8 / 256.0;
  const double max_gradient = config.match_max_gradient_q8 / 256.0;
  for (uint32_t i = 0; i < count; ++i) {
    rvdnav_match& m = matches[i];
    m.disparity = m.score = 0.0;
    m.accepted = 0;
    Search there;
    if (!search_row(config, rig, 0, left, right, disparities, m.x, m.y, scratch, &there)) continue;
    m.disparity = there.disparity;
    m.score = there.score;
    if (there.score < min_score || there.rival > uniqueness * there.score) continue;
    Search back;
    if (!search_row(config, rig, 1, right, left, disparities, m.x - there.disparity, m.y, scratch, &back)) continue;
    if (std::abs(back.disparity - there.disparity) > consistency) continue;
    m.accepted = 1;
  }
  // Disparity gradient: of two neighbours on a bar that contradict each other the one with the lower score goes.
  for (uint32_t i = 0; i + 1 < count; ++i) {
    rvdnav_match& a = matches[i];
    rvdnav_match& b = matches[i + 1];
    if (a.accepted == 0 || b.accepted == 0 || a.bar != b.bar) continue;
    // Between the cyclopean images of the points, halfway between both views.
    const double dx = (a.x - 0.5 * a.disparity) - (b.x - 0.5 * b.disparity);
    const double separation = std::sqrt(dx * dx + (a.y - b.y) * (a.y - b.y));
    if (std::abs(a.disparity - b.disparity) <= max_gradient * separation) continue;
    (a.score < b.score ? a : b).accepted = 0;
  }
}

}  // namespace rvdnav
