// What several steps of the measurement hold to.
#pragma once

namespace rvdnav {

// Weight from which a sample or a line counts as agreeing with the pose.
constexpr double kTrusted = 0.2;

}  // namespace rvdnav
