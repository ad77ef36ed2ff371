// Checks of the structures that a context is made from.
#include <cmath>

#include <Eigen/Core>
#include <Eigen/Geometry>

#include "abi/abi.hpp"
#include "epipolar.hpp"
#include "thin.hpp"

namespace rvdnav {
namespace {

using Eigen::Vector3d;

constexpr double kRotationTolerance = 1e-6;
constexpr double kMinEdge = 1e-3;      // metres
constexpr double kMinSine = 1e-2;      // between adjoining edges
constexpr double kMaxOffPlane = 1e-2;  // of the longest edge

bool within(int32_t value, int32_t low, int32_t high) { return value >= low && value <= high; }

template <typename... Values>
bool all_finite(Values... values) {
  return (std::isfinite(values) && ...);
}

bool is_rotation(const double* row_major) {
  const Eigen::Map<const Eigen::Matrix<double, 3, 3, Eigen::RowMajor>> R(row_major);
  if (!R.allFinite()) return false;
  const Eigen::Matrix3d off = R * R.transpose() - Eigen::Matrix3d::Identity();
  const Vector3d x = R.row(0), y = R.row(1), z = R.row(2);
  return off.cwiseAbs().maxCoeff() <= kRotationTolerance && x.cross(y).dot(z) > 0.0;
}

bool is_usable(const rvdnav_camera& camera) {
  return all_finite(camera.fx, camera.fy, camera.cx, camera.cy, camera.k1, camera.k2, camera.p1, camera.p2) &&
         camera.fx > 0.0 && camera.fy > 0.0 && is_rotation(camera.R_rect_cam);
}

Vector3d point(const double p[3]) { return {p[0], p[1], p[2]}; }

// Four corners in one plane, no two together, no three in a line.
bool is_quadrilateral(const double corners[4][3]) {
  double longest = 0.0;
  Vector3d normal = Vector3d::Zero();
  for (int32_t i = 0; i < 4; ++i) {
    const Vector3d corner = point(corners[i]);
    if (!corner.allFinite()) return false;
    const Vector3d next = point(corners[(i + 1) % 4]) - corner;
    const Vector3d previous = point(corners[(i + 3) % 4]) - corner;
    if (!next.allFinite() || next.norm() < kMinEdge) return false;
    const Vector3d turn = next.cross(previous);
    if (turn.norm() < kMinSine * next.norm() * previous.norm()) return false;
    if (i == 0) normal = turn.normalized();
    longest = std::max(longest, next.norm());
  }
  return std::abs(normal.dot(point(corners[2]) - point(corners[0]))) <= kMaxOffPlane * longest;
}

// Each inner edge lies off its outer one, to the same side as the frame's middle.
bool is_inside(const double inner[4][3], const double outer[4][3]) {
  Vector3d middle = Vector3d::Zero();
  for (int32_t i = 0; i < 4; ++i) middle += 0.25 * point(outer[i]);
  for (int32_t i = 0; i < 4; ++i) {
    const Vector3d a = point(outer[i]);
    const Vector3d along = (point(outer[(i + 1) % 4]) - a).normalized();
    Vector3d inward = middle - a;
    inward -= inward.dot(along) * along;
    const double reach = inward.norm();
    if (reach < kMinEdge) return false;
    for (const int32_t k : {i, (i + 1) % 4}) {
      const double depth = (point(inner[k]) - a).dot(inward) / reach;
      if (!(depth > 0.0 && depth < 2.0 * reach)) return false;
    }
  }
  return true;
}

}  // namespace

rvdnav_status validate(const rvdnav_config& c) {
  if (c.struct_size != sizeof(c)) return RVDNAV_ERROR_STRUCT_SIZE;
  const bool isa = within(c.isa, RVDNAV_ISA_AUTO, RVDNAV_ISA_NEON);
  const bool edges = within(c.edge_floor, 1, 255) && within(c.edge_weber_q8, 0, 255) && within(c.edge_knee, 0, 255) &&
                     within(c.edge_min_run, 0, kMaxMinRun);
  const bool hough =
      within(c.hough_rho_bins, 64, 4096) && within(c.hough_spread, 0, 45) && within(c.peak_min_votes, 1, 65535);
  const bool segments = within(c.segment_min_length, 4, 4096) && within(c.segment_max_gap, 0, 4096);
  const bool limits = within(c.max_edgels, 1, 1 << 20) && within(c.max_peaks, 1, 1 << 14) &&
                      within(c.max_segments, 1, 1 << 14) && within(c.max_bars, 1, 1 << 14) &&
                      within(c.max_hypotheses, 1, 1 << 20);
  const bool match = within(c.match_half_window, 1, kMaxHalfWindow) &&
                     within(c.match_row_tolerance, 0, kMaxRowTolerance) && within(c.match_min_score_q8, 0, 256) &&
                     within(c.match_uniqueness_q8, 0, 256) && within(c.match_max_gradient_q8, 1, 1 << 16) &&
                     within(c.match_consistency_q8, 0, 1 << 16);
  const bool range = all_finite(c.range_min, c.range_max) && c.range_min > 0.0 && c.range_max > c.range_min;
  const bool blur = std::isfinite(c.blur_sigma) && c.blur_sigma > 0.0 && c.blur_sigma <= 10.0;
  return isa && edges && hough && segments && limits && match && range && blur ? RVDNAV_OK : RVDNAV_ERROR_ARGUMENT;
}

rvdnav_status validate(const rvdnav_rig& rig) {
  if (rig.struct_size != sizeof(rig)) return RVDNAV_ERROR_STRUCT_SIZE;
  if (!within(rig.width, 16, 2048) || !within(rig.height, 16, 2048)) return RVDNAV_ERROR_CALIBRATION;
  if (!within(rig.camera_count, 1, RVDNAV_CAMERAS)) return RVDNAV_ERROR_CALIBRATION;
  if (!all_finite(rig.focal_rect, rig.baseline) || rig.focal_rect <= 0.0) return RVDNAV_ERROR_CALIBRATION;
  if (rig.camera_count == 1 ? rig.baseline != 0.0 : rig.baseline <= 0.0) return RVDNAV_ERROR_CALIBRATION;
  for (int32_t i = 0; i < rig.camera_count; ++i) {
    if (!is_usable(rig.camera[i])) return RVDNAV_ERROR_CALIBRATION;
  }
  return RVDNAV_OK;
}

rvdnav_status validate(const rvdnav_target& target) {
  if (target.struct_size != sizeof(target)) return RVDNAV_ERROR_STRUCT_SIZE;
  const bool thickness = std::isfinite(target.thickness) && target.thickness >= 0.0;
  const bool shape = is_quadrilateral(target.outer) && is_quadrilateral(target.inner);
  return thickness && shape && is_inside(target.inner, target.outer) ? RVDNAV_OK : RVDNAV_ERROR_TARGET;
}

}  // namespace rvdnav
