// Poses of the bracket proposed from three adjoining bars in one view.
#pragma once

#include <cstdint>

#include "bracket_model.hpp"
#include "bracket_support.hpp"
#include "rect_rig.hpp"

namespace rvdnav {

struct ViewBars {
  ViewSegments segments;
  const rvdnav_bar* bars;
  uint32_t count;
};

struct RangeGate {
  double min, max;  // metres from the world's origin

  bool admits(const Pose& pose) const {
    const double range = pose.p.norm();
    return range >= min && range <= max;
  }
};

struct Proposal {
  Pose pose;
  double support;  // fraction of the edges' length supported in the proposing view
  int32_t camera;
};

// Seen length over width of the longest bar that is read as one of the bracket's.
double max_slenderness(const BracketModel& model);

// The best-supported proposals of one view, best first.  A bar with two others that start near its ends on the same
// side is read as each of the bracket's bars in turn; the six lines give the pose, and its mirror image about the line
// of sight, which one view can hardly tell apart, is proposed beside it.  At most max_readings are tried.  Returns the
// number written; *limited tells that readings or proposals had to be left out.
uint32_t propose_brackets(const RectRig& rig, const BracketModel& model, int32_t camera, const ViewBars& view,
                          const RangeGate& gate, uint32_t max_readings, Proposal* proposals, uint32_t capacity,
                          bool* limited);

}  // namespace rvdnav
