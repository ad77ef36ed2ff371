#include "bracket_model.hpp"

#include <Eigen/Geometry>

namespace rvdnav {
namespace {

Eigen::Vector3d vector(const double v[3]) { return {v[0], v[1], v[2]}; }

}  // namespace

BracketModel make_bracket_model(const rvdnav_target& target) {
  BracketModel m;
  m.back = Eigen::Vector3d(target.thickness, 0.0, 0.0);
  for (int32_t k = 0; k < RVDNAV_BARS; ++k) {
    const int32_t s = kStartApex[k];
    const int32_t e = kEndApex[k];
    m.edge[2 * k] = {vector(target.outer[s]), vector(target.outer[e])};
    m.edge[2 * k + 1] = {vector(target.inner[s]), vector(target.inner[e])};
    // The corners of the centre lines lie half-way between the outer and the inner apexes.
    m.axis_start[k] = 0.5 * (m.edge[2 * k].a + m.edge[2 * k + 1].a);
    m.axis_end[k] = 0.5 * (m.edge[2 * k].b + m.edge[2 * k + 1].b);
    const Eigen::Vector3d along = (m.edge[2 * k].b - m.edge[2 * k].a).normalized();
    const Eigen::Vector3d across = m.edge[2 * k + 1].a - m.edge[2 * k].a;
    m.bar_width[k] = along.cross(across).norm();
    m.outward[2 * k + 1] = (across - along.dot(across) * along).normalized();
    m.outward[2 * k] = -m.outward[2 * k + 1];
  }
  return m;
}

}  // namespace rvdnav
