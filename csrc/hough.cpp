#include "hough.hpp"

namespace rvdnav {

void hough_vote(const rvdnav_edgel* edgels, uint32_t n, int32_t rho_bins, int32_t spread, const Kernels& kernels,
                uint16_t* acc) {
  for (ptrdiff_t i = 0; i < static_cast<ptrdiff_t>(kThetaBins) * rho_bins; ++i) acc[i] = 0;
  kernels.vote(edgels, n, rho_bins, spread, acc);
}

}  // namespace rvdnav
