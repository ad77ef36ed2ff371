#include "lens.hpp"

#include <limits>

namespace rvdnav {
namespace {

struct Distorted {
  double x, y;
  double dxx, dxy, dyy;  // partial derivatives; the matrix is symmetric
};

// Radial and tangential distortion of a normalised point (Brown's model).
Distorted distort(const rvdnav_camera& camera, double x, double y) {
  const double r2 = x * x + y * y;
  const double radial = 1.0 + r2 * (camera.k1 + r2 * camera.k2);
  const double slope = 2.0 * (camera.k1 + 2.0 * camera.k2 * r2);  // of radial, over x by x
  const double p1 = camera.p1, p2 = camera.p2;
  return {x * radial + 2.0 * p1 * x * y + p2 * (r2 + 2.0 * x * x),
          y * radial + p1 * (r2 + 2.0 * y * y) + 2.0 * p2 * x * y, radial + x * x * slope + 2.0 * p1 * y + 6.0 * p2 * x,
          x * y * slope + 2.0 * p1 * x + 2.0 * p2 * y, radial + y * y * slope + 6.0 * p1 * y + 2.0 * p2 * x};
}

// Whether the distorted radius r (1 + k1 r^2 + k2 r^4) still grows at r^2, and did so all the way from the middle.
bool unfolded(const rvdnav_camera& camera, double r2) {
  const double k1 = camera.k1, k2 = camera.k2;
  if (!(1.0 + r2 * (3.0 * k1 + 5.0 * k2 * r2) > 0.0)) return false;
  // With k1 < 0 < k2 the growth has its least at r^2 = -3 k1 / (10 k2), and is positive again beyond.
  return !(k1 < 0.0 && k2 > 0.0 && -3.0 * k1 < 10.0 * k2 * r2 && 9.0 * k1 * k1 >= 20.0 * k2);
}

}  // namespace

void rect_to_raw(const rvdnav_rig& rig, int camera, double x, double y, double* u, double* v) {
  const rvdnav_camera& c = rig.camera[camera];
  const double* R = c.R_rect_cam;
  const double f = rig.focal_rect;
  // Its transpose maps rectified axes to the camera's.
  const double X = R[0] * x + R[3] * y + R[6] * f;
  const double Y = R[1] * x + R[4] * y + R[7] * f;
  const double Z = R[2] * x + R[5] * y + R[8] * f;
  const double a = X / Z, b = Y / Z;
  if (!(Z > 0.0) || !unfolded(c, a * a + b * b)) {
    *u = *v = std::numeric_limits<double>::quiet_NaN();
    return;
  }
  const Distorted d = distort(c, a, b);
  *u = c.fx * d.x + c.cx;
  *v = c.fy * d.y + c.cy;
}

bool raw_to_rect(const rvdnav_rig& rig, int camera, double u, double v, double* x, double* y) {
  const rvdnav_camera& c = rig.camera[camera];
  const double goal_x = (u - c.cx) / c.fx, goal_y = (v - c.cy) / c.fy;
  double px = goal_x, py = goal_y;
  bool converged = false;
  for (int iteration = 0; iteration < 20 && !converged; ++iteration) {
    const Distorted d = distort(c, px, py);
    const double det = d.dxx * d.dyy - d.dxy * d.dxy;
    if (!(det > 0.0)) return false;  // beyond the fold
    const double ex = goal_x - d.x, ey = goal_y - d.y;
    const double step_x = (d.dyy * ex - d.dxy * ey) / det;
    const double step_y = (d.dxx * ey - d.dxy * ex) / det;
    px += step_x;
    py += step_y;
    converged = step_x * step_x + step_y * step_y < 1e-24;
  }
  const double* R = c.R_rect_cam;
  const double Z = R[6] * px + R[7] * py + R[8];
  if (!converged || !(Z > 0.0) || !unfolded(c, px * px + py * py)) return false;
  *x = rig.focal_rect * (R[0] * px + R[1] * py + R[2]) / Z;
  *y = rig.focal_rect * (R[3] * px + R[4] * py + R[5]) / Z;
  return true;
}

}  // namespace rvdnav
