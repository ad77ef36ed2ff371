// The host's steady clock, for stage times.
#include <chrono>

#include "rvdnav/rvdnav.h"

uint64_t rvdnav_host_clock(void*) {
  const auto now = std::chrono::steady_clock::now().time_since_epoch();
  return static_cast<uint64_t>(std::chrono::duration_cast<std::chrono::nanoseconds>(now).count());
}
