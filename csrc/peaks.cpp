#include "peaks.hpp"

#include "integers.hpp"
#include "parabola.hpp"
#include "peak_list.hpp"

namespace rvdnav {
namespace {

// Twice the votes, also beyond the accumulator's ends: half a turn on, theta is the same and rho negated.
class Space {
 public:
  Space(const uint16_t* acc, int32_t rho_bins) : acc_(acc), rho_bins_(rho_bins) {}

  struct Cell {
    int32_t row, rho;
  };

  Cell wrap(int32_t row, int32_t rho) const {
    if (row >= 0 && row < kThetaBins) return {row, rho};
    return {row < 0 ? row + kThetaBins : row - kThetaBins, 2 * (rho_bins_ / 2) - rho};
  }

  int32_t votes(Cell cell) const {
    const uint16_t* row = acc_ + static_cast<ptrdiff_t>(cell.row) * rho_bins_;
    if (cell.rho > 0 && cell.rho < rho_bins_ - 1) return row[cell.rho - 1] + 2 * row[cell.rho] + row[cell.rho + 1];
    const auto at = [&](int32_t rho) { return rho >= 0 && rho < rho_bins_ ? row[rho] : 0; };
    return at(cell.rho - 1) + 2 * at(cell.rho) + at(cell.rho + 1);
  }
  int32_t votes(int32_t row, int32_t rho) const { return votes(wrap(row, rho)); }

  // Whether the highest cell around is this one, which has `value`; of equal ones, the first.
  bool is_peak(int32_t row, int32_t rho, int32_t value) const {
    for (int32_t k = 0; k <= 2 * kPeakRows; ++k) {
      const int32_t dy = (k & 1) != 0 ? (k + 1) / 2 : -k / 2;  // its own row first: most cells fail there
      for (int32_t dx = -kPeakCells; dx <= kPeakCells; ++dx) {
        const Cell other = wrap(row + dy, rho + dx);
        const int32_t rival = votes(other);
        const bool earlier = other.row != row ? other.row < row : other.rho < rho;
        if (rival > value || (rival == value && earlier)) return false;
      }
    }
    return true;
  }

 private:
  const uint16_t* acc_;
  int32_t rho_bins_;
};

// Calls visit(row, rho, twice the votes) for the cells with at least min_votes, but those at the rows' ends and those
// lower than one beside them in the row.
template <typename Visit>
void for_each_high_cell(const uint16_t* acc, int32_t rho_bins, int32_t min_votes, const Kernels& kernels, Visit visit) {
  const auto least = static_cast<uint16_t>(clamp(2 * min_votes, 1, UINT16_MAX));
  for (int32_t row = 0; row < kThetaBins; ++row) {
    const uint16_t* cells = acc + static_cast<ptrdiff_t>(row) * rho_bins;
    for (int32_t first = 1; first < rho_bins - 1; first += 32) {
      const int32_t end = smaller(first + 32, rho_bins - 1);
      const bool inside = first >= 2 && first + 34 <= rho_bins;
      const uint32_t some = end - first < 32 ? (uint32_t{1} << (end - first)) - 1 : ~uint32_t{0};
      for (uint32_t rest = inside ? kernels.high_cells(cells + first, least) : some; rest != 0; rest &= rest - 1) {
        const int32_t rho = first + __builtin_ctz(rest);
        const int32_t value = cells[rho - 1] + 2 * cells[rho] + cells[rho + 1];
        if (value > 0 && value >= 2 * min_votes) visit(row, rho, value);
      }
    }
  }
}

}  // namespace

uint32_t hough_peaks(const uint16_t* acc, int32_t rho_bins, int32_t min_votes, const Kernels& kernels, rvdnav_peak* out,
                     uint32_t capacity, uint32_t* total) {
  const Space space(acc, rho_bins);
  PeakList best(out, capacity);
  *total = 0;
  for_each_high_cell(acc, rho_bins, min_votes, kernels, [&](int32_t row, int32_t rho, int32_t value) {
    if (!space.is_peak(row, rho, value)) return;
    const int32_t aside_q8 = parabola_q8(space.votes(row, rho - 1), value, space.votes(row, rho + 1));
    const int32_t turn_q8 = parabola_q8(space.votes(row - 1, rho), value, space.votes(row + 1, rho));
    ++*total;
    best.add(half_turn_normalised({(rho - rho_bins / 2) * 256 + aside_q8, (row + kThetaFirst) * 256 + turn_q8,
                                   static_cast<uint32_t>((value + 1) / 2)}));
  });
  return best.sort();
}

}  // namespace rvdnav
