// Where the edges of the drawn bracket are expected: windows of Hough space around their exact projection.
#pragma once

#include <algorithm>

#include "scene.hpp"

namespace scene {

struct Pixel {
  double x, y;
};

// Rectified pixel of a point in C.
inline Pixel project(int camera, const Placement& at, const double p[3]) {
  const double c = std::cos(at.angle);
  const double s = std::sin(at.angle);
  const double x_W = at.range + c * p[0] + s * p[2];
  const double y_W = at.y + p[1];
  const double z_W = at.z - s * p[0] + c * p[2] - (camera == 0 ? kBaseline : 0.0);
  return {-kFocal * z_W / x_W, kFocal * y_W / x_W};
}

inline std::vector<rvdnav_window> windows(int camera, const Placement& at) {
  constexpr double kPi = 3.14159265358979323846;
  constexpr int kCorner[4][2] = {{0, 1}, {2, 3}, {1, 2}, {3, 0}};  // of l1, l2, l3, l4
  const rvdnav_target t = target();
  std::vector<rvdnav_window> out;
  for (int edge = 0; edge < RVDNAV_EDGES; ++edge) {
    const auto* corners = edge % 2 == 0 ? t.outer : t.inner;
    const Pixel a = project(camera, at, corners[kCorner[edge / 2][0]]);
    const Pixel b = project(camera, at, corners[kCorner[edge / 2][1]]);
    rvdnav_window w = {};
    w.edge = edge;
    w.theta = std::atan2(b.x - a.x, a.y - b.y);
    while (w.theta >= 0.75 * kPi) w.theta -= kPi;
    while (w.theta < -0.25 * kPi) w.theta += kPi;
    const double c = std::cos(w.theta);
    const double s = std::sin(w.theta);
    w.rho = a.x * c + a.y * s;
    w.half_rho = 4.0;
    w.half_theta = 0.05;
    const double ta = a.y * c - a.x * s;
    const double tb = b.y * c - b.x * s;
    w.t_min = std::min(ta, tb);
    w.t_max = std::max(ta, tb);
    out.push_back(w);
  }
  return out;
}

}  // namespace scene
