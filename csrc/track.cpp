#include "track.hpp"

#include "hough_trig.hpp"
#include "parabola.hpp"

namespace rvdnav {
namespace {

constexpr double kDegrees = 180.0 / 3.14159265358979323846;
constexpr double kFar = 16384.0;  // pixels; beyond every image
constexpr double kQ19 = 1 << 19;
constexpr int32_t kHalfTurn = 360;                // rows of half a degree
constexpr int32_t kCellMargin = kFlankCells + 2;  // comparison and smoothing
constexpr int32_t kRowMargin = 2;
constexpr int32_t kVoteUnit = 3 * 4;  // weight of an edgel in the middle of a smoothed peak
constexpr int32_t kLeastVotes = 6;

double clamp(double v, double low, double high) { return v < low ? low : v > high ? high : v; }

int32_t floor_of(double v) {
  const int32_t i = static_cast<int32_t>(v);
  return i > v ? i - 1 : i;
}

struct Range {
  int32_t first, last;
};

struct LongRange {
  int64_t first, last;
};

// The whole numbers in [middle - half, middle + half], the nearest one if there is none.
Range whole_numbers(double middle, double half) {
  const Range inside = {-floor_of(half - middle), floor_of(middle + half)};
  const int32_t nearest = round_half_away(middle);
  return inside.first <= inside.last ? inside : Range{nearest, nearest};
}

// Row i stands for theta = i / 2 - 45 degrees, whatever the turn.
UnitQ14 row_unit(int32_t row) {
  const int32_t turns = row >= 0 ? row / kHalfTurn : -((kHalfTurn - 1 - row) / kHalfTurn);
  const UnitQ14 u = kHoughTrig.half_degree[row - turns * kHalfTurn];
  if (turns % 2 == 0) return u;
  return {static_cast<int16_t>(-u.c), static_cast<int16_t>(-u.s)};
}

// A window in whole rows and cells (cell j: rho = j / 2 pixels).
struct Window {
  Range rows, cells;
  int32_t middle_row;
  LongRange t_q19;   // of the edgels that may vote, along the middle row's line
  int32_t shear;     // cells a row
  int32_t shear_q8;  // the same, finer
  int32_t least;     // smoothed votes of a peak
  int32_t polarity;  // 0: of either
  int32_t level;     // gradient direction that belongs to the polarity, 256 to the turn
};

Window whole_window(const rvdnav_window& w, int32_t max_shear) {
  const double row = (clamp(w.theta * kDegrees, -360.0, 360.0) + 45.0) * 2.0;
  const double rho = clamp(w.rho, -kFar, kFar);
  const double t_min = clamp(w.t_min, -kFar, kFar), t_max = clamp(w.t_max, t_min, kFar);
  Window whole = {};
  whole.rows = whole_numbers(row, clamp(w.half_theta * kDegrees, 0.0, kTrackMaxHalfTheta) * 2.0);
  whole.cells = whole_numbers(rho * 2.0, clamp(w.half_rho, 0.0, kTrackMaxHalfRho) * 2.0);
  whole.middle_row = round_half_away(row);
  // The middle row's line is turned a little against the window's: along it, t is less by rho times the turn.
  const double turn = (whole.middle_row - row) / (2.0 * kDegrees);
  const double margin = 0.1 * (t_max - t_min) + 4.0;
  const auto q19 = [](double t) { return static_cast<int64_t>(t < 0 ? t * kQ19 - 0.5 : t * kQ19 + 0.5); };
  whole.t_q19 = {q19(t_min - margin - rho * turn), q19(t_max + margin - rho * turn)};
  // Half a degree moves rho by t / 2 degrees; a cell is half a pixel.
  const double shear = clamp((t_min + t_max) / 2.0 / kDegrees, -max_shear, max_shear);
  whole.shear = round_half_away(shear);
  whole.shear_q8 = round_half_away(shear * 256.0);
  whole.polarity = w.polarity;
  whole.level =
      round_half_away(clamp(w.theta * kDegrees, -360.0, 360.0) * (256.0 / 360.0)) + (w.polarity < 0 ? 128 : 0);
  const int32_t quarter = round_half_away((t_max - t_min) * 0.25);
  whole.least = kVoteUnit * (quarter > kLeastVotes ? quarter : kLeastVotes);
  return whole;
}

// The accumulator around a window.
class Neighbourhood {
 public:
  Neighbourhood(const Window& window, uint16_t* scratch) : window_(window), acc_(scratch) {
    const int32_t margin = kCellMargin + 2 * (window.shear < 0 ? -window.shear : window.shear);
    first_row_ = window.rows.first - kRowMargin;
    last_row_ = window.rows.last + kRowMargin;
    first_cell_ = window.cells.first - margin;
    cells_ = window.cells.last + margin + 1 - first_cell_;
  }

  void vote(const rvdnav_edgel* edgels, uint32_t n, int32_t spread) {
    const int32_t rows = last_row_ - first_row_ + 1;
    for (int32_t i = 0; i < rows * cells_; ++i) acc_[i] = 0;
    UnitQ14 units[kTrackMaxRows];
    for (int32_t i = 0; i < rows; ++i) units[i] = row_unit(first_row_ + i);
    const UnitQ14 middle = row_unit(window_.middle_row);
    for (uint32_t i = 0; i < n; ++i) {
      const rvdnav_edgel& e = edgels[i];
      const int64_t t = int64_t{e.y_q5} * middle.c - int64_t{e.x_q5} * middle.s;
      if (t < window_.t_q19.first || t > window_.t_q19.last) continue;
      // Half a turn around the wanted direction; the spread below narrows it.
      if (window_.polarity != 0 && ((e.direction - window_.level + 64) & 255) > 128) continue;
      const int32_t own = nearest_turn(((e.direction & 127) * 45 + 8) / 16 - 2 * kThetaFirst);
      const int32_t from = own - 2 * spread > first_row_ ? own - 2 * spread : first_row_;
      const int32_t to = own + 2 * spread < last_row_ ? own + 2 * spread : last_row_;
      for (int32_t row = from; row <= to; ++row) {
        const UnitQ14 u = units[row - first_row_];
        const int64_t rho = int64_t{e.x_q5} * u.c + int64_t{e.y_q5} * u.s;
        const int64_t cell = floor_shift(rho + (1 << 17), 18) - first_cell_;
        if (cell >= 0 && cell < cells_) ++acc_[(row - first_row_) * cells_ + cell];
      }
    }
  }

  // Votes smoothed by the triangle (1 2 3 2 1) along rho and by (1 2 1) along the shear.
  int32_t smoothed(int32_t row, int32_t cell) const {
    return across(row - 1, cell - window_.shear) + 2 * across(row, cell) + across(row + 1, cell + window_.shear);
  }

 private:
  // The row of a gradient's direction, of all half turns the one nearest to the window.
  int32_t nearest_turn(int32_t row) const {
    constexpr int32_t kTurns = 8;  // more than there are: keeps the dividend positive
    const int32_t away = row - window_.middle_row + kHalfTurn / 2 + kTurns * kHalfTurn;
    return row - (away / kHalfTurn - kTurns) * kHalfTurn;
  }

  int32_t across(int32_t row, int32_t cell) const {
    const uint16_t* p = acc_ + (row - first_row_) * cells_ + (cell - first_cell_);
    return p[-2] + 2 * p[-1] + 3 * p[0] + 2 * p[1] + p[2];
  }

  const Window& window_;
  uint16_t* acc_;
  int32_t first_row_, last_row_, first_cell_, cells_;
};

// Whether nothing beside the cell is higher, outside the window as well: then it is no flank of something else.
bool is_maximum(const Neighbourhood& space, const Window& w, int32_t row, int32_t cell, int32_t value) {
  for (int32_t d = -kFlankCells; d <= kFlankCells; ++d) {
    if (space.smoothed(row, cell + d) > value) return false;
    if (space.smoothed(row - 1, cell - w.shear + d) > value) return false;
    if (space.smoothed(row + 1, cell + w.shear + d) > value) return false;
  }
  return true;
}

rvdnav_peak highest_peak(const Neighbourhood& space, const Window& w, const rvdnav_peak& none) {
  int32_t best = w.least - 1, best_row = 0, best_cell = 0;
  for (int32_t row = w.rows.first; row <= w.rows.last; ++row) {
    for (int32_t cell = w.cells.first; cell <= w.cells.last; ++cell) {
      const int32_t value = space.smoothed(row, cell);
      if (value <= best || !is_maximum(space, w, row, cell, value)) continue;
      best = value;
      best_row = row;
      best_cell = cell;
    }
  }
  if (best < w.least) return none;
  const int32_t aside =
      parabola_q8(space.smoothed(best_row, best_cell - 1), best, space.smoothed(best_row, best_cell + 1));
  const int32_t turn = parabola_q8(space.smoothed(best_row - 1, best_cell - w.shear), best,
                                   space.smoothed(best_row + 1, best_cell + w.shear));
  const int32_t rho_q9 = best_cell * 256 + aside + round_divide(w.shear_q8 * turn, 256);
  const int32_t theta_q9 = best_row * 256 + turn + 2 * kThetaFirst * 256;
  return {round_divide(rho_q9, 2), round_divide(theta_q9, 2), static_cast<uint32_t>(best / kVoteUnit)};
}

}  // namespace

void hough_track(const rvdnav_edgel* edgels, uint32_t n, int32_t spread, const rvdnav_window* windows,
                 uint32_t n_windows, const TrackScratch& scratch, rvdnav_peak* out) {
  for (uint32_t i = 0; i < n_windows; ++i) {
    const Window window = whole_window(windows[i], scratch.max_shear);
    Neighbourhood space(window, scratch.votes);
    space.vote(edgels, n, spread);
    const rvdnav_peak none = {(window.cells.first + window.cells.last) * 64,
                              window.middle_row * 128 + kThetaFirst * 256, 0};
    out[i] = half_turn_normalised(highest_peak(space, window, none));
  }
}

}  // namespace rvdnav
