// Times of the stages by the caller's clock.
#pragma once

#include <cstdint>

#include "rvdnav/rvdnav.h"

namespace rvdnav {

class StageClock {
 public:
  StageClock(const rvdnav_config& config, uint64_t* stage_ns) : config_(config), stage_ns_(stage_ns), last_(now()) {}

  // Adds the time since the last call (or the start) to the stage.
  void lap(int32_t stage) {
    const uint64_t time = now();
    stage_ns_[stage] += time - last_;
    last_ = time;
  }

 private:
  uint64_t now() const { return config_.clock != nullptr ? config_.clock(config_.clock_user) : 0; }

  const rvdnav_config& config_;
  uint64_t* stage_ns_;
  uint64_t last_;
};

}  // namespace rvdnav
