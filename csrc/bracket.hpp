// Acquisition: the bracket's pose without a prior, from what one or both views propose.
#pragma once

#include <cstdint>

#include "bracket_propose.hpp"

namespace rvdnav {

// The best pose that the segments of the views support, out of the proposals carried on and refined over all views.
// views: the left and the right one; one that is not present is left out.  Where nothing fits, all is tried once more
// with wider tolerances, as what is known of bracket and rig may not be quite true: *loose says so, and *right_shift by
// how many pixels the right view then lies off.
rvdnav_bracket acquire_bracket(const RectRig& rig, const BracketModel& model, const ViewSegments views[2],
                               const bool present[2], const RangeGate& gate, const Proposal* proposals,
                               uint32_t proposal_count, Eigen::Vector2d* right_shift, bool* loose);

}  // namespace rvdnav
