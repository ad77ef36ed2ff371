// Edgels along straight lines, for the tests of Hough space.
#pragma once

#include <cmath>
#include <vector>

#include "plain.hpp"
#include "rvdnav/rvdnav.h"

namespace plain {

struct Line {
  double rho, theta_deg, t_min, t_max;
  bool flipped = false;  // brighter towards smaller rho
};

inline double radians(double degrees) { return degrees * M_PI / 180.0; }

// One edgel a pixel, rounded to the pixel grid like the edges of an image; directions with some noise.
inline void add_line(std::vector<rvdnav_edgel>& edgels, const Line& line, Random& random,
                     double direction_noise = 3.0) {
  const double c = std::cos(radians(line.theta_deg)), s = std::sin(radians(line.theta_deg));
  for (double t = line.t_min; t <= line.t_max; t += 1.0) {
    const double x = std::round(line.rho * c - t * s), y = std::round(line.rho * s + t * c);
    const double degrees =
        line.theta_deg + (line.flipped ? 180.0 : 0.0) + random.real(-direction_noise, direction_noise);
    const long level = std::lround(degrees * 256.0 / 360.0);
    edgels.push_back(
        {static_cast<int32_t>(x * 32), static_cast<int32_t>(y * 32), static_cast<uint8_t>(level & 255), {}});
  }
}

inline void add_clutter(std::vector<rvdnav_edgel>& edgels, int count, Random& random) {
  for (int i = 0; i < count; ++i)
    edgels.push_back({random.between(-350 * 32, 350 * 32),
                      random.between(-280 * 32, 280 * 32),
                      static_cast<uint8_t>(random.between(0, 255)),
                      {}});
}

// How far a line given as a peak lies from another at the ends of the latter, pixels.
inline double distance_at_ends(const Line& line, double rho, double theta) {
  double worst = 0;
  const double c = std::cos(radians(line.theta_deg)), s = std::sin(radians(line.theta_deg));
  for (double t : {line.t_min, line.t_max}) {
    const double x = line.rho * c - t * s, y = line.rho * s + t * c;
    worst = std::fmax(worst, std::fabs(x * std::cos(theta) + y * std::sin(theta) - rho));
  }
  return worst;
}

inline double rho_of(const rvdnav_peak& peak) { return peak.rho_q8 / 256.0; }
inline double theta_of(const rvdnav_peak& peak) { return radians(peak.theta_q8 / 256.0); }

}  // namespace plain
