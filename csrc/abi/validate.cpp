// Checks of the structures that a context is made from.
#include <string.h>

#include <cmath>

#include <Eigen/Core>
#include <Eigen/Geometry>

#include "abi/abi.hpp"
#include "epipolar.hpp"
#include "hough.hpp"
#include "thin.hpp"

using namespace rvdnav;

namespace rvdnav {
namespace {

using Eigen::Vector3d;

constexpr double kRotationTolerance = 1e-6;
constexpr double kMinEdge = 1e-3;      // metres
constexpr double kMinSine = 1e-2;      // between adjoining edges
constexpr double kMaxOffPlane = 1e-2;  // of the longest edge

constexpr int32_t kMinSide = 16, kMaxSide = 4096;          // of an image, pixels
constexpr double kMinFocal = 1.0, kMaxFocal = 1e6;         // pixels
constexpr double kMaxCentre = 16384.0;                     // pixels
constexpr double kMaxRadial = 1e9, kMaxTangential = 1e3;   // distortion
constexpr double kMinBaseline = 1e-6, kMaxBaseline = 1e3;  // metres
constexpr double kMaxExtent = 1e3;                         // of a target, metres

// False for a NaN.
bool within(double value, double low, double high) { return value >= low && value <= high; }

// A number of the configuration and its range.
struct Setting {
  const char* name;
  int32_t rvdnav_config::*integer;  // or
  double rvdnav_config::*real;
  double low, high;

  constexpr Setting(const char* name_, int32_t rvdnav_config::*field, double low_, double high_)
      : name(name_), integer(field), real(nullptr), low(low_), high(high_) {}
  constexpr Setting(const char* name_, double rvdnav_config::*field, double low_, double high_)
      : name(name_), integer(nullptr), real(field), low(low_), high(high_) {}

  double value(const rvdnav_config& config) const { return integer != nullptr ? config.*integer : config.*real; }
};

#define SETTING(field, low, high) Setting(#field, &rvdnav_config::field, low, high)
constexpr Setting kSettings[] = {
    SETTING(isa, RVDNAV_ISA_AUTO, RVDNAV_ISA_SSE2),
    SETTING(edge_floor, 1, 255),
    SETTING(edge_weber_q8, 0, 255),
    SETTING(edge_knee, 0, 255),
    SETTING(edge_min_run, 0, kMaxMinRun),
    SETTING(hough_rho_bins, 0, kMaxRhoBins),
    SETTING(hough_spread, 0, 45),
    SETTING(peak_min_votes, 1, 65535),
    SETTING(segment_min_length, 4, 4096),
    SETTING(segment_max_gap, 0, 4096),
    SETTING(max_edgels, 0, 1 << 22),
    SETTING(max_peaks, 1, 1 << 14),
    SETTING(max_segments, 1, 1 << 14),
    SETTING(max_bars, 1, 1 << 14),
    SETTING(max_hypotheses, 1, 1 << 20),
    SETTING(match_half_window, 1, kMaxHalfWindow),
    SETTING(match_row_tolerance, 0, kMaxRowTolerance),
    SETTING(match_min_score_q8, 0, 256),
    SETTING(match_uniqueness_q8, 0, 256),
    SETTING(match_max_gradient_q8, 1, 1 << 16),
    SETTING(match_consistency_q8, 0, 1 << 16),
    SETTING(range_min, 1e-3, 1e4),
    SETTING(range_max, 1e-3, 1e4),
    SETTING(blur_sigma, 0.1, 10.0),
};
#undef SETTING

bool is_rotation(const double* row_major) {
  const Eigen::Map<const Eigen::Matrix<double, 3, 3, Eigen::RowMajor>> R(row_major);
  if (!R.allFinite()) return false;
  const Eigen::Matrix3d off = R * R.transpose() - Eigen::Matrix3d::Identity();
  const Vector3d x = R.row(0), y = R.row(1), z = R.row(2);
  return off.cwiseAbs().maxCoeff() <= kRotationTolerance && x.cross(y).dot(z) > 0.0;
}

bool is_usable(const rvdnav_camera& c) {
  const auto small = [](double value, double most) { return within(value, -most, most); };
  return within(c.fx, kMinFocal, kMaxFocal) && within(c.fy, kMinFocal, kMaxFocal) && small(c.cx, kMaxCentre) &&
         small(c.cy, kMaxCentre) && small(c.k1, kMaxRadial) && small(c.k2, kMaxRadial) && small(c.p1, kMaxTangential) &&
         small(c.p2, kMaxTangential) && is_rotation(c.R_rect_cam);
}

Vector3d point(const double p[3]) { return {p[0], p[1], p[2]}; }

// Four corners in one plane, no two together, no three in a line.
bool is_quadrilateral(const double corners[4][3]) {
  double longest = 0.0;
  Vector3d normal = Vector3d::Zero();
  for (int32_t i = 0; i < 4; ++i) {
    const Vector3d corner = point(corners[i]);
    if (!(corner.cwiseAbs().maxCoeff() <= kMaxExtent)) return false;
    const Vector3d next = point(corners[(i + 1) % 4]) - corner;
    const Vector3d previous = point(corners[(i + 3) % 4]) - corner;
    if (!(next.norm() >= kMinEdge)) return false;
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
  for (const Setting& setting : kSettings) {
    if (!within(setting.value(c), setting.low, setting.high)) return RVDNAV_ERROR_ARGUMENT;
  }
  return c.range_max > c.range_min ? RVDNAV_OK : RVDNAV_ERROR_ARGUMENT;
}

rvdnav_status validate(const rvdnav_rig& rig) {
  if (rig.struct_size != sizeof(rig)) return RVDNAV_ERROR_STRUCT_SIZE;
  const bool stereo = rig.camera_count == RVDNAV_CAMERAS;
  const bool usable = within(rig.width, kMinSide, kMaxSide) && within(rig.height, kMinSide, kMaxSide) &&
                      within(rig.camera_count, 1, RVDNAV_CAMERAS) && within(rig.focal_rect, kMinFocal, kMaxFocal) &&
                      (stereo ? within(rig.baseline, kMinBaseline, kMaxBaseline) : rig.baseline == 0.0);
  if (!usable) return RVDNAV_ERROR_CALIBRATION;
  for (int32_t i = 0; i < rig.camera_count; ++i) {
    if (!is_usable(rig.camera[i])) return RVDNAV_ERROR_CALIBRATION;
  }
  return RVDNAV_OK;
}

rvdnav_status validate(const rvdnav_target& target) {
  if (target.struct_size != sizeof(target)) return RVDNAV_ERROR_STRUCT_SIZE;
  const bool thickness = within(target.thickness, 0.0, kMaxExtent);
  const bool shape = is_quadrilateral(target.outer) && is_quadrilateral(target.inner);
  return thickness && shape && is_inside(target.inner, target.outer) ? RVDNAV_OK : RVDNAV_ERROR_TARGET;
}

}  // namespace rvdnav

rvdnav_status rvdnav_config_range(const char* name, double* low, double* high) {
  if (name == nullptr || low == nullptr || high == nullptr) return RVDNAV_ERROR_NULL;
  for (const Setting& setting : kSettings) {
    if (strcmp(name, setting.name) != 0) continue;
    *low = setting.low;
    *high = setting.high;
    return RVDNAV_OK;
  }
  return RVDNAV_ERROR_ARGUMENT;
}
