#include "hough.hpp"

#include "hough_trig.hpp"

namespace rvdnav {

void hough_vote(const rvdnav_edgel* edgels, uint32_t n, int32_t rho_bins, int32_t spread, uint16_t* acc) {
  for (ptrdiff_t i = 0; i < static_cast<ptrdiff_t>(kThetaBins) * rho_bins; ++i) acc[i] = 0;
  // Products of Q5 and Q14 are Q19; the offset takes rho to the middle cell and rounds.
  const int64_t offset = (int64_t{rho_bins / 2} << 19) + (1 << 18);
  for (uint32_t i = 0; i < n; ++i) {
    const rvdnav_edgel& e = edgels[i];
    int32_t row = theta_row(e.direction) - spread;
    if (row < 0) row += kThetaBins;
    for (int32_t k = -spread; k <= spread; ++k) {
      const UnitQ14 u = kHoughTrig.half_degree[2 * row];
      const int64_t rho = int64_t{e.x_q5} * u.c + int64_t{e.y_q5} * u.s + offset;
      const int64_t cell = rho >= 0 ? rho >> 19 : rho_bins;
      if (cell < rho_bins) ++acc[static_cast<ptrdiff_t>(row) * rho_bins + cell];
      if (++row == kThetaBins) row = 0;
    }
  }
}

}  // namespace rvdnav
