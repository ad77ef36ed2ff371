#include "apexes.hpp"

#include "line2.hpp"

namespace rvdnav {
namespace {

constexpr double kMinSine = 0.2;  // between two lines that make an apex

Line2 line_of(const rvdnav_line& line) { return Line2::from_angle(line.rho, line.theta); }

}  // namespace

uint32_t intersect_lines(const rvdnav_line lines[RVDNAV_EDGES], double apexes[RVDNAV_APEXES][2]) {
  uint32_t mask = 0;
  for (int32_t bar = 0; bar < RVDNAV_BARS; ++bar) {
    for (int32_t side = 0; side < 2; ++side) {
      const rvdnav_line& a = lines[2 * kPreviousBar[bar] + side];
      const rvdnav_line& b = lines[2 * bar + side];
      const int32_t apex = RVDNAV_BARS * side + kStartApex[bar];
      apexes[apex][0] = apexes[apex][1] = 0.0;
      Eigen::Vector2d p;
      if (a.found == 0 || b.found == 0 || !intersect(line_of(a), line_of(b), kMinSine, &p)) continue;
      apexes[apex][0] = p.x();
      apexes[apex][1] = p.y();
      mask |= 1U << apex;
    }
  }
  return mask;
}

}  // namespace rvdnav
