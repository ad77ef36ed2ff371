// Images of straight blurred steps, area-sampled, with the places of the steps known exactly.
#pragma once

#include <cmath>
#include <vector>

#include "lens.hpp"
#include "line2.hpp"
#include "plain.hpp"
#include "scene.hpp"

namespace stepped {

// A small view without distortion: rectified x, y are u - cx, v - cy.
inline rvdnav_rig small_rig(int width = 160, int height = 120) {
  rvdnav_rig rig = scene::rig();
  rig.width = width;
  rig.height = height;
  for (rvdnav_camera& c : rig.camera) {
    c.cx = 0.5 * (width - 1);
    c.cy = 0.5 * (height - 1);
  }
  return rig;
}

// Grey against the distance from a line: a base level and steps of Gaussian blur at given distances.
struct Step {
  double at, rise;
};

struct Look {
  double base, blur;
  std::vector<Step> steps;
};

// Sum of normal deviates, near enough to one for noise in an image.
inline double normal(plain::Random& random) {
  double sum = 0.0;
  for (int i = 0; i < 12; ++i) sum += random.real(0.0, 1.0);
  return sum - 6.0;
}

// Beyond this distance from the line nothing changes any more, pixels.
constexpr double kNear = 15.0;

// The grey value at a distance from the line.
inline double grey_at(const Look& look, double distance) {
  double grey = look.base;
  for (const Step& s : look.steps) {
    const double z = (distance - s.at) / look.blur;
    grey += s.rise * (z > 8.0 ? 1.0 : z < -8.0 ? 0.0 : 0.5 * std::erfc(-z / std::sqrt(2.0)));
  }
  return grey;
}

// 5x5 samples a pixel through the lens, which is straight within one; then white noise and rounding to 8 bits.
inline plain::Grey draw(const rvdnav_rig& rig, int camera, const rvdnav::Line2& line, const Look& look, double noise,
                        plain::Random& random) {
  plain::Grey image(rig.width, rig.height);
  const auto distance_at = [&](double u, double v) {
    double x = 0.0, y = 0.0;
    rvdnav::raw_to_rect(rig, camera, u, v, &x, &y);
    return line.distance({x, y});
  };
  for (int v = 0; v < rig.height; ++v) {
    for (int u = 0; u < rig.width; ++u) {
      const double middle = distance_at(u, v);
      if (std::abs(middle) > kNear) {
        image.at(u, v) = static_cast<uint8_t>(std::round(grey_at(look, middle) + noise * normal(random)));
        continue;
      }
      const double du = distance_at(u + 0.5, v) - distance_at(u - 0.5, v);
      const double dv = distance_at(u, v + 0.5) - distance_at(u, v - 0.5);
      double sum = 0.0;
      for (int i = 0; i < 25; ++i)
        sum += grey_at(look, middle + du * (0.2 * (i % 5) - 0.4) + dv * (0.2 * (i / 5) - 0.4));
      const double grey = std::round(sum / 25.0 + noise * normal(random));
      image.at(u, v) = static_cast<uint8_t>(std::fmin(std::fmax(grey, 0.0), 255.0));
    }
  }
  return image;
}

}  // namespace stepped
