// Plane geometry of image lines in normal form: x cos(theta) + y sin(theta) = rho.
#pragma once

#include <cmath>

#include <Eigen/Core>

#include "math/elementary.hpp"

namespace rvdnav {

constexpr double kPi = 3.14159265358979323846;

struct Line2 {
  Eigen::Vector2d normal;  // (cos theta, sin theta)
  double rho;

  static Line2 from_angle(double rho, double theta) { return {{math::cos(theta), math::sin(theta)}, rho}; }

  // Along the line; t grows in this direction.
  Eigen::Vector2d direction() const { return {-normal.y(), normal.x()}; }
  double distance(const Eigen::Vector2d& p) const { return normal.dot(p) - rho; }
  Eigen::Vector2d at(double t) const { return normal * rho + direction() * t; }
};

// The angle of a line's normal, moved into [-45, 135) degrees; *flipped tells that the normal (and rho) changed sign.
inline double normalized_theta(double theta, bool* flipped) {
  *flipped = false;
  while (theta >= 0.75 * kPi) {
    theta -= kPi;
    *flipped = !*flipped;
  }
  while (theta < -0.25 * kPi) {
    theta += kPi;
    *flipped = !*flipped;
  }
  return theta;
}

// Difference of two line angles (mod pi), in [-pi/2, pi/2].
inline double line_angle_difference(double a, double b) {
  double d = a - b;
  while (d > 0.5 * kPi) d -= kPi;
  while (d < -0.5 * kPi) d += kPi;
  return d;
}

// Where two lines meet; false when they are closer to parallel than the sine given.
inline bool intersect(const Line2& a, const Line2& b, double min_sine, Eigen::Vector2d* p) {
  const double det = a.normal.x() * b.normal.y() - a.normal.y() * b.normal.x();
  if (std::abs(det) < min_sine) return false;
  *p = Eigen::Vector2d(a.rho * b.normal.y() - b.rho * a.normal.y(), a.normal.x() * b.rho - b.normal.x() * a.rho) / det;
  return true;
}

}  // namespace rvdnav
