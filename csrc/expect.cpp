#include "expect.hpp"

#include <algorithm>

#include "line2.hpp"
#include "math/elementary.hpp"

namespace rvdnav {

uint32_t expect_edges(const RectRig& rig, const BracketModel& model, int32_t camera, const Pose& pose, double half_rho,
                      double half_theta, rvdnav_window windows[RVDNAV_EDGES]) {
  constexpr double kNearest = 0.02;  // metres
  uint32_t n = 0;
  for (int32_t k = 0; k < RVDNAV_EDGES; ++k) {
    const Eigen::Vector3d a = pose * model.edge[k].a;
    const Eigen::Vector3d b = pose * model.edge[k].b;
    if (a.z() < kNearest || b.z() < kNearest) continue;
    const Eigen::Vector2d p = rig.project(camera, a);
    const Eigen::Vector2d q = rig.project(camera, b);
    bool flipped = false;
    const double theta = normalized_theta(math::atan2(q.x() - p.x(), p.y() - q.y()), &flipped);
    const Line2 line = Line2::from_angle(0.0, theta);
    const double tp = line.direction().dot(p);
    const double tq = line.direction().dot(q);
    windows[n++] = {k, 0, line.normal.dot(p), theta, half_rho, half_theta, std::min(tp, tq), std::max(tp, tq)};
  }
  return n;
}

}  // namespace rvdnav
