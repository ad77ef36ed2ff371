// The bracket before the rectified pair in exact geometry: poses, images of its edges, segments as a view offers them.
#pragma once

#include <cmath>
#include <utility>
#include <vector>

#include <Eigen/Geometry>

#include "bracket_support.hpp"
#include "plain.hpp"
#include "rect_rig.hpp"
#include "scene.hpp"

namespace views {

using Eigen::Vector2d;
using Eigen::Vector3d;
using rvdnav::Pose;

inline rvdnav::RectRig rig() { return {scene::kFocal, scene::kBaseline}; }

// Apexes at the ends of l1, l2, l3, l4.
constexpr int kCorner[4][2] = {{0, 1}, {2, 3}, {1, 2}, {3, 0}};

// Facing the cameras at a depth, then rolled about the line of sight and tilted about an axis across it.
inline Pose random_pose(plain::Random& random, double near, double far, double max_tilt, double max_roll) {
  Eigen::Matrix3d facing;
  facing << 0, 0, -1,  //
      0, 1, 0,         //
      1, 0, 0;
  const double axis = random.real(-M_PI, M_PI);
  const Eigen::AngleAxisd roll(random.real(-max_roll, max_roll), Vector3d::UnitZ());
  const Eigen::AngleAxisd tilt(random.real(0.0, max_tilt), Vector3d(std::cos(axis), std::sin(axis), 0.0));
  const double z = random.real(near, far);
  const Vector3d p(-0.5 * scene::kBaseline + z * random.real(-0.12, 0.12), z * random.real(-0.12, 0.12), z);
  return {tilt * (roll * facing), p};
}

inline Vector2d image_of(int camera, const Pose& pose, const double p_C[3]) {
  const Vector3d p = pose.R * Vector3d(p_C[0], p_C[1], p_C[2]) + pose.p;
  const double x = p.x() + (camera == 0 ? scene::kBaseline : 0.0);
  return {scene::kFocal * x / p.z(), scene::kFocal * p.y() / p.z()};
}

// Both ends of an edge in a view.
inline std::pair<Vector2d, Vector2d> edge_image(int camera, const Pose& pose, int edge) {
  const rvdnav_target t = scene::target();
  const auto* corners = edge % 2 == 0 ? t.outer : t.inner;
  return {image_of(camera, pose, corners[kCorner[edge / 2][0]]), image_of(camera, pose, corners[kCorner[edge / 2][1]])};
}

// The segment from a to b whose bright side holds a point.
inline rvdnav_segment segment_between(const Vector2d& a, const Vector2d& b, const Vector2d& bright) {
  rvdnav_segment s = {};
  s.theta = std::atan2(b.x() - a.x(), a.y() - b.y());
  while (s.theta >= 0.75 * M_PI) s.theta -= M_PI;
  while (s.theta < -0.25 * M_PI) s.theta += M_PI;
  const Vector2d n(std::cos(s.theta), std::sin(s.theta));
  s.rho = n.dot(a);
  const double ta = n.x() * a.y() - n.y() * a.x();
  const double tb = n.x() * b.y() - n.y() * b.x();
  s.t_min = std::min(ta, tb);
  s.t_max = std::max(ta, tb);
  s.polarity = n.dot(bright) > s.rho ? 1 : -1;
  s.support = static_cast<uint32_t>((b - a).norm());
  s.rms = 0.2;
  return s;
}

struct View {
  std::vector<rvdnav_segment> segments;
  std::vector<rvdnav::Line2> lines;

  void add(const rvdnav_segment& s) {
    segments.push_back(s);
    lines.push_back(rvdnav::Line2::from_angle(s.rho, s.theta));
  }

  rvdnav::ViewSegments face() const { return {segments.data(), lines.data(), static_cast<uint32_t>(segments.size())}; }
};

// The bracket's edges, bright bars on a dark ground, their ends displaced by up to `noise` pixels in both directions.
inline void add_bracket(View& view, int camera, const Pose& pose, plain::Random& random, double noise,
                        uint32_t missing_bars = 0) {
  const auto jitter = [&] { return Vector2d(random.real(-noise, noise), random.real(-noise, noise)); };
  for (int edge = 0; edge < RVDNAV_EDGES; ++edge) {
    if ((missing_bars >> (edge / 2) & 1U) != 0) continue;
    const auto [a, b] = edge_image(camera, pose, edge);
    const auto [c, d] = edge_image(camera, pose, edge ^ 1);
    view.add(segment_between(a + jitter(), b + jitter(), 0.5 * (c + d)));
  }
}

// Moves everything in a view by so many pixels.
inline void shift(View& view, const Vector2d& by) {
  for (size_t i = 0; i < view.segments.size(); ++i) {
    rvdnav_segment& s = view.segments[i];
    const rvdnav::Line2& line = view.lines[i];
    s.rho += line.normal.dot(by);
    s.t_min += line.direction().dot(by);
    s.t_max += line.direction().dot(by);
    view.lines[i] = rvdnav::Line2::from_angle(s.rho, s.theta);
  }
}

// Short lines anywhere, and a panel: a grid of thin bright lines, each with two edges.
inline void add_distractors(View& view, plain::Random& random, int count) {
  const auto anywhere = [&] { return Vector2d(random.real(-340, 340), random.real(-280, 280)); };
  for (int i = 0; i < count; ++i) {
    const Vector2d a = anywhere();
    const double angle = random.real(0, M_PI);
    const Vector2d b = a + random.real(16, 120) * Vector2d(std::cos(angle), std::sin(angle));
    view.add(segment_between(a, b, anywhere()));
  }
  const Vector2d middle = anywhere();
  const double turn = random.real(0, M_PI);
  for (int family = 0; family < 2; ++family) {
    const double angle = turn + 0.5 * M_PI * family;
    const Vector2d along(std::cos(angle), std::sin(angle));
    const Vector2d across(-along.y(), along.x());
    for (int i = -3; i <= 3; ++i) {
      for (const double side : {-1.5, 1.5}) {
        const Vector2d on = middle + (22.0 * i + side) * across;
        view.add(segment_between(on - 75.0 * along, on + 75.0 * along, middle + 22.0 * i * across));
      }
    }
  }
}

// Rotation angle between two poses and distance relative to the depth.
inline double turn_of(const Pose& a, const Pose& b) { return Eigen::AngleAxisd(a.R * b.R.transpose()).angle(); }
inline double shift_of(const Pose& a, const Pose& b) { return (a.p - b.p).norm() / b.p.z(); }

// The pose of a result, in R.
inline Pose pose_of(const rvdnav_bracket& bracket) {
  Eigen::Matrix3d R_W_C;
  for (int i = 0; i < 9; ++i) R_W_C(i / 3, i % 3) = bracket.R_W_C[i];
  const Vector3d p_W(bracket.p_W[0], bracket.p_W[1], bracket.p_W[2]);
  // x_R = -z_W, y_R = y_W, z_R = x_W
  Eigen::Matrix3d R;
  R.row(0) = -R_W_C.row(2);
  R.row(1) = R_W_C.row(1);
  R.row(2) = R_W_C.row(0);
  return {R, {-p_W.z(), p_W.y(), p_W.x()}};
}

}  // namespace views
