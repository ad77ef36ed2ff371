#include "line_pose.hpp"

#include <cmath>

#include <Eigen/Cholesky>
#include <Eigen/Geometry>

namespace rvdnav {
namespace {

using Matrix6d = Eigen::Matrix<double, 6, 6>;
using Vector6d = Eigen::Matrix<double, 6, 1>;

constexpr double kNearest = 0.02;  // metres in front of a camera
constexpr double kSettled = 1e-4;  // pixels; change of the residual between two steps
constexpr int32_t kPatience = 4;   // iterations before the residual is judged

Eigen::Matrix3d exp_rotation(const Eigen::Vector3d& w) {
  const double angle = w.norm();
  if (angle < 1e-12) return Eigen::Matrix3d::Identity();
  return Eigen::AngleAxisd(angle, w / angle).toRotationMatrix();
}

// Sum of weighted squares; with normal equations where asked for.  Negative when a point is not in front of a camera.
double evaluate(const RectRig& rig, const LineMatch* matches, uint32_t count, const Pose& pose, Matrix6d* H,
                Vector6d* g) {
  double cost = 0.0;
  if (H != nullptr) {
    H->setZero();
    g->setZero();
  }
  for (uint32_t i = 0; i < count; ++i) {
    const LineMatch& m = matches[i];
    for (const Eigen::Vector3d* p_C : {&m.from, &m.to}) {
      const Eigen::Vector3d arm = pose.R * *p_C;
      const Eigen::Vector3d p = arm + pose.p - rig.centre(m.camera);
      if (p.z() < kNearest) return -1.0;
      const double inv = 1.0 / p.z();
      const Eigen::Vector2d xy(rig.focal * p.x() * inv, rig.focal * p.y() * inv);
      const double r = m.line.distance(xy);
      cost += m.weight * r * r;
      if (H == nullptr) continue;
      // dr/dp = n^T dpi/dp; a rotation exp([w]x) R moves the point by w x arm.
      const Eigen::Vector3d d(rig.focal * inv * m.line.normal.x(), rig.focal * inv * m.line.normal.y(),
                              -inv * m.line.normal.dot(xy));
      Vector6d J;
      J << d, arm.cross(d);
      H->noalias() += m.weight * J * J.transpose();
      *g += m.weight * r * J;
    }
  }
  return cost;
}

}  // namespace

bool fit_pose_to_lines(const RectRig& rig, const LineMatch* matches, uint32_t count, int32_t max_iterations,
                       double hopeless_rms, Pose* pose, double* rms) {
  double weights = 0.0;
  for (uint32_t i = 0; i < count; ++i) weights += 2.0 * matches[i].weight;
  Matrix6d H;
  Vector6d g;
  double cost = evaluate(rig, matches, count, *pose, &H, &g);
  if (cost < 0.0) return false;
  double lambda = 1e-3;
  for (int32_t iteration = 0; iteration < max_iterations; ++iteration) {
    if (iteration == kPatience && cost > hopeless_rms * hopeless_rms * weights) return false;
    Matrix6d damped = H;
    damped.diagonal() *= 1.0 + lambda;
    const Eigen::LDLT<Matrix6d> ldlt(damped);
    if (ldlt.info() != Eigen::Success || !ldlt.isPositive()) return false;
    const Vector6d step = -ldlt.solve(g);
    if (!step.allFinite()) return false;
    const Pose trial = {exp_rotation(step.tail<3>()) * pose->R, pose->p + step.head<3>()};
    const double trial_cost = evaluate(rig, matches, count, trial, nullptr, nullptr);
    if (trial_cost >= 0.0 && trial_cost <= cost) {
      *pose = trial;
      const bool settled = cost - trial_cost < kSettled * kSettled * count;
      lambda = std::fmax(lambda * 0.1, 1e-9);
      cost = evaluate(rig, matches, count, *pose, &H, &g);
      if (settled) break;
    } else {
      lambda *= 10.0;
      if (lambda > 1e6) break;
    }
  }
  *rms = std::sqrt(cost / weights);
  return true;
}

}  // namespace rvdnav
