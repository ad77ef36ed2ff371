#include "crossing_match.hpp"

#include "correlation.hpp"
#include "epipolar.hpp"
#include "integers.hpp"

namespace rvdnav {
namespace {

constexpr int32_t kReach = 5;             // pixels of a level beyond what the coarser one found
constexpr int32_t kOpenUniqueness = 205;  // of 256, where no coarser level narrows the search: grids repeat themselves
constexpr int32_t kMaxSlopeRatio = 4;     // between the views
constexpr int32_t kSupportColumns = 8, kSupportRows = 4;  // neighbourhood of the disparity gradient
constexpr int32_t kMinSupport = 2;                        // neighbours within the gradient that a match needs

constexpr int32_t nearest(int32_t x_q8) { return (x_q8 + 128) >> 8; }

// The grey window around a crossing, Q4, with its sums.
struct Window {
  int32_t value[kMaxWindow * kMaxWindow];
  int64_t sum, square;
};

bool window_fits(const LevelView& view, int32_t x, int32_t y, int32_t h) {
  if (y < h || y >= view.image.height - h) return false;
  const RowSpan span = level_span(view, y);
  return x - h >= span.begin && x + h < span.end;
}

void take_window(const PyramidLevel& image, int32_t x, int32_t y, int32_t h, Window* window) {
  int32_t* to = window->value;
  window->sum = window->square = 0;
  for (int32_t dy = -h; dy <= h; ++dy) {
    const uint16_t* row = image.smoothed + static_cast<ptrdiff_t>(y + dy) * image.width + x;
    for (int32_t dx = -h; dx <= h; ++dx) {
      const int32_t grey = row[dx] >> 4;
      *to++ = grey;
      window->sum += grey;
      window->square += grey * grey;
    }
  }
}

int32_t window_score(const Window& window, const PyramidLevel& image, int32_t x, int32_t y, int32_t h) {
  const int32_t* a = window.value;
  int64_t sum = 0, square = 0, cross = 0;
  for (int32_t dy = -h; dy <= h; ++dy) {
    const uint16_t* row = image.smoothed + static_cast<ptrdiff_t>(y + dy) * image.width + x;
    for (int32_t dx = -h; dx <= h; ++dx) {
      const int32_t grey = row[dx] >> 4;
      sum += grey;
      square += grey * grey;
      cross += *a++ * grey;
    }
  }
  const int64_t n = int64_t{2 * h + 1} * (2 * h + 1);
  return correlation_q15(n * cross - window.sum * sum, n * window.square - window.sum * window.sum,
                         n * square - sum * sum);
}

// The same sign of contrast, about as steep, and within 30 degrees of the same direction.
bool is_alike(const Crossing& a, const Crossing& b) {
  if ((a.slope > 0) != (b.slope > 0)) return false;
  if (magnitude(a.slope) > kMaxSlopeRatio * magnitude(b.slope) ||
      magnitude(b.slope) > kMaxSlopeRatio * magnitude(a.slope))
    return false;
  const int64_t dot = int64_t{a.gx} * b.gx + int64_t{a.gy} * b.gy;
  const int64_t turn = int64_t{a.gx} * b.gy - int64_t{a.gy} * b.gx;
  return 7 * (turn < 0 ? -turn : turn) <= 4 * dot;
}

struct Interval {
  int32_t low, high;
  int32_t uniqueness_q8;  // that a match within it needs
};

// Disparities, pixels of the fine level, that the coarser level's tiles around a place allow.
Interval allowed(const DisparityTiles& coarse, int32_t x, int32_t y, const Interval& full, int32_t uniqueness_q8) {
  const int32_t column = x / (2 * kTile), row = y / (2 * kTile);
  Interval found = {full.high, full.low, uniqueness_q8};
  for (int32_t r = larger(row - 1, 0); r <= smaller(row + 1, coarse.rows - 1); ++r) {
    for (int32_t c = larger(column - 1, 0); c <= smaller(column + 1, coarse.columns - 1); ++c) {
      const DisparityTile& tile = coarse.tiles[static_cast<ptrdiff_t>(r) * coarse.columns + c];
      if (tile.high < tile.low) continue;
      found.low = smaller(found.low, 2 * tile.low - kReach);
      found.high = larger(found.high, 2 * tile.high + kReach);
    }
  }
  if (found.high < found.low) return full;
  return {larger(found.low, full.low), smaller(found.high, full.high), uniqueness_q8};
}

// First crossing of a row at or beyond x.
uint32_t first_from(const CrossingRows& rows, int32_t y, int64_t x_q8) {
  uint32_t begin = rows.begin(y), end = rows.end(y);
  while (begin < end) {
    const uint32_t middle = begin + (end - begin) / 2;
    if (rows.crossings[middle].x_q8 < x_q8) {
      begin = middle + 1;
    } else {
      end = middle;
    }
  }
  return begin;
}

struct Best {
  int32_t right, score, rival;
};

// The right crossing of row y that fits a left one's window best within an interval, and the score of the next best.
// Right crossings learn whose best they are.
Best search(const LevelView& right, const CrossingRows& left, int32_t left_index, const Window& window, int32_t y,
            int32_t h, const Interval& range, const CrossingScratch& scratch) {
  const Crossing& from = left.crossings[left_index];
  Best best = {-1, 0, 0};
  for (uint32_t k = first_from(right.rows, y, int64_t{from.x_q8} - 256 * range.high); k < right.rows.end(y); ++k) {
    const Crossing& to = right.rows.crossings[k];
    if (to.x_q8 > from.x_q8 - 256 * range.low) break;
    const int32_t x = nearest(to.x_q8);
    if (!is_alike(from, to) || !window_fits(right, x, y, h)) continue;
    const int32_t score = window_score(window, right.image, x, y, h);
    if (score > scratch.right_score[k]) {
      scratch.right_score[k] = score;
      scratch.right_left[k] = left_index;
    }
    if (score > best.score) {
      best = {static_cast<int32_t>(k), score, best.score};
    } else {
      best.rival = larger(best.rival, score);
    }
  }
  return best;
}

// Whether enough matches around lie within the disparity gradient, and no more beyond it.
bool is_supported(const LevelView& left, const LevelView& right, const CrossingMatch* matches, uint32_t i, int32_t y,
                  int32_t max_gradient_q8) {
  const CrossingRows& rows = left.rows;
  const int32_t x = rows.crossings[i].x_q8;
  const int32_t d = x - right.rows.crossings[matches[i].right].x_q8;
  int32_t agreeing = 0, contradicting = 0;
  for (int32_t row = larger(y - kSupportRows, 0); row <= smaller(y + kSupportRows, left.image.height - 1); ++row) {
    const int64_t last = int64_t{x} + 256 * kSupportColumns;
    for (uint32_t k = first_from(rows, row, int64_t{x} - 256 * kSupportColumns); k < rows.end(row); ++k) {
      if (rows.crossings[k].x_q8 > last) break;
      if (k == i || matches[k].right < 0) continue;
      const int32_t other = rows.crossings[k].x_q8 - right.rows.crossings[matches[k].right].x_q8;
      // Between the cyclopean images, halfway between both views.
      const int64_t dx = int64_t{2} * (rows.crossings[k].x_q8 - x) - (other - d);
      const int64_t dy = int64_t{512} * (row - y);
      const int64_t change = int64_t{512} * (other - d) / larger(max_gradient_q8, 1);
      ++(change * change <= dx * dx + dy * dy ? agreeing : contradicting);
    }
  }
  return agreeing >= kMinSupport && agreeing >= contradicting;
}

}  // namespace

void match_crossings(const LevelView& left, const LevelView& right, int32_t low, int32_t high,
                     const DisparityTiles* coarse, const CrossingLimits& limits, const CrossingScratch& scratch,
                     CrossingMatch* matches) {
  const int32_t h = limits.half_window;
  const uint32_t right_total = right.rows.end(right.image.height - 1);
  for (uint32_t k = 0; k < right_total; ++k) {
    scratch.right_score[k] = -1;
    scratch.right_left[k] = -1;
  }
  const Interval open = {low, high, smaller(limits.uniqueness_q8, kOpenUniqueness)};
  Window window;
  for (int32_t y = 0; y < left.image.height; ++y) {
    for (uint32_t i = left.rows.begin(y); i < left.rows.end(y); ++i) {
      matches[i] = {-1, 0};
      const int32_t x = nearest(left.rows.crossings[i].x_q8);
      if (!window_fits(left, x, y, h)) continue;
      take_window(left.image, x, y, h, &window);
      const Interval range = coarse == nullptr ? open : allowed(*coarse, x, y, open, limits.uniqueness_q8);
      const Best best = search(right, left.rows, static_cast<int32_t>(i), window, y, h, range, scratch);
      const bool unique = int64_t{best.rival} * 256 <= int64_t{range.uniqueness_q8} * best.score;
      if (unique && best.score >= limits.min_score_q15) matches[i] = {best.right, best.score};
    }
  }
  const uint32_t left_total = left.rows.end(left.image.height - 1);
  for (uint32_t i = 0; i < left_total; ++i) {
    if (matches[i].right >= 0 && scratch.right_left[matches[i].right] != static_cast<int32_t>(i)) matches[i].right = -1;
  }
  // All are judged before any goes.
  for (int32_t y = 0; y < left.image.height; ++y) {
    for (uint32_t i = left.rows.begin(y); i < left.rows.end(y); ++i)
      scratch.keep[i] = matches[i].right >= 0 && is_supported(left, right, matches, i, y, limits.max_gradient_q8);
  }
  for (uint32_t i = 0; i < left_total; ++i) {
    if (scratch.keep[i] == 0) matches[i].right = -1;
  }
}

void fill_tiles(const LevelView& left, const LevelView& right, const CrossingMatch* matches, DisparityTiles* tiles) {
  for (int32_t i = 0; i < tiles->columns * tiles->rows; ++i) tiles->tiles[i] = {1, 0};
  for (int32_t y = 0; y < left.image.height; ++y) {
    for (uint32_t i = left.rows.begin(y); i < left.rows.end(y); ++i) {
      if (matches[i].right < 0) continue;
      const int32_t x_q8 = left.rows.crossings[i].x_q8;
      const int32_t d = nearest(x_q8 - right.rows.crossings[matches[i].right].x_q8);
      const int32_t column = smaller((x_q8 >> 8) / kTile, tiles->columns - 1);
      DisparityTile& tile = tiles->tiles[static_cast<ptrdiff_t>(y / kTile) * tiles->columns + column];
      const bool first = tile.high < tile.low;
      tile.low = static_cast<int16_t>(first ? d : smaller(tile.low, d));
      tile.high = static_cast<int16_t>(first ? d : larger(tile.high, d));
    }
  }
}

}  // namespace rvdnav
