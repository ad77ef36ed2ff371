// The best of many peaks in an array of the caller's.
#pragma once

#include "rvdnav/rvdnav.h"

namespace rvdnav {

// More votes first, then by theta and rho.
inline bool ranks_before(const rvdnav_peak& a, const rvdnav_peak& b) {
  if (a.votes != b.votes) return a.votes > b.votes;
  return a.theta_q8 != b.theta_q8 ? a.theta_q8 < b.theta_q8 : a.rho_q8 < b.rho_q8;
}

// A heap with the last-ranking peak on top, which the next better one replaces.
class PeakList {
 public:
  PeakList(rvdnav_peak* peaks, uint32_t capacity) : peaks_(peaks), capacity_(capacity) {}

  void add(const rvdnav_peak& peak) {
    if (count_ < capacity_) {
      uint32_t i = count_++;
      for (; i > 0 && ranks_before(peaks_[(i - 1) / 2], peak); i = (i - 1) / 2) peaks_[i] = peaks_[(i - 1) / 2];
      peaks_[i] = peak;
    } else if (capacity_ > 0 && ranks_before(peak, peaks_[0])) {
      sink(peak, count_);
    }
  }

  // Puts the peaks into their order; nothing may be added after it.  Returns their number.
  uint32_t sort() {
    for (uint32_t last = count_; last > 1;) {
      --last;
      const rvdnav_peak top = peaks_[0];
      sink(peaks_[last], last);
      peaks_[last] = top;
    }
    return count_;
  }

 private:
  // Puts a peak in the place of the top one of the first `size`.
  void sink(const rvdnav_peak& peak, uint32_t size) {
    const rvdnav_peak sinking = peak;
    uint32_t i = 0;
    for (uint32_t child = 1; child < size; child = 2 * i + 1) {
      if (child + 1 < size && ranks_before(peaks_[child], peaks_[child + 1])) ++child;
      if (!ranks_before(sinking, peaks_[child])) break;
      peaks_[i] = peaks_[child];
      i = child;
    }
    peaks_[i] = sinking;
  }

  rvdnav_peak* peaks_;
  uint32_t capacity_;
  uint32_t count_ = 0;
};

}  // namespace rvdnav
