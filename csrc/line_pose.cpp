#include "line_pose.hpp"

#include <cmath>

#include <Eigen/Cholesky>
#include <Eigen/Geometry>

#include "math/elementary.hpp"

namespace rvdnav {
namespace {

// Pose, then the right view's shift.
constexpr int32_t kParameters = 8;
using Matrix8d = Eigen::Matrix<double, kParameters, kParameters>;
using Vector8d = Eigen::Matrix<double, kParameters, 1>;

constexpr double kNearest = 0.02;  // metres in front of a camera
constexpr double kSettled = 1e-4;  // pixels; change of the residual between two steps
constexpr int32_t kPatience = 4;   // iterations before the residual is judged

Eigen::Matrix3d exp_rotation(const Eigen::Vector3d& w) {
  const double angle = w.norm();
  if (angle < 1e-12) return Eigen::Matrix3d::Identity();
  const Eigen::Vector3d axis = w / angle;
  Eigen::Matrix3d K;
  K << 0.0, -axis.z(), axis.y(), axis.z(), 0.0, -axis.x(), -axis.y(), axis.x(), 0.0;
  return Eigen::Matrix3d::Identity() + math::sin(angle) * K + (1.0 - math::cos(angle)) * (K * K);
}

// Sum of weighted squares; with normal equations where asked for.  Negative when a point is not in front of a camera.
// stiffness: inverse variance of the right view's shift, negative where it stays as it is.
double evaluate(const RectRig& rig, const LineMatch* matches, uint32_t count, double stiffness, const Pose& pose,
                Matrix8d* H, Vector8d* g) {
  const bool shifted = stiffness >= 0.0;
  double cost = shifted ? stiffness * rig.right_shift.squaredNorm() : 0.0;
  if (H != nullptr) {
    H->setZero();
    g->setZero();
    // A shift that stays has equations of its own.
    H->diagonal().tail<2>().setConstant(shifted ? stiffness : 1.0);
    if (shifted) g->tail<2>() = stiffness * rig.right_shift;
  }
  for (uint32_t i = 0; i < count; ++i) {
    const LineMatch& m = matches[i];
    const bool moves = shifted && m.camera == 1;
    for (const Eigen::Vector3d* p_C : {&m.from, &m.to}) {
      const Eigen::Vector3d arm = pose.R * *p_C;
      const Eigen::Vector3d p_R = arm + pose.p;
      const Eigen::Vector3d p = p_R - rig.centre(m.camera);
      if (p.z() < kNearest) return -1.0;
      const double inv = 1.0 / p.z();
      const Eigen::Vector2d xy(rig.focal * p.x() * inv, rig.focal * p.y() * inv);
      const double r = m.line.distance(rig.project(m.camera, p_R));
      cost += m.weight * r * r;
      if (H == nullptr) continue;
      // dr/dp = n^T dpi/dp; a rotation exp([w]x) R moves the point by w x arm.
      const Eigen::Vector3d d(rig.focal * inv * m.line.normal.x(), rig.focal * inv * m.line.normal.y(),
                              -inv * m.line.normal.dot(xy));
      Vector8d J;
      J << d, arm.cross(d), Eigen::Vector2d::Zero();
      if (moves) J.tail<2>() = m.line.normal;
      H->noalias() += m.weight * J * J.transpose();
      *g += m.weight * r * J;
    }
  }
  return cost;
}

bool fit(RectRig* rig, const LineMatch* matches, uint32_t count, double shift_sigma, int32_t max_iterations,
         double hopeless_rms, Pose* pose, double* rms) {
  double weights = 0.0;
  for (uint32_t i = 0; i < count; ++i) weights += 2.0 * matches[i].weight;
  // In the same unit as the lines: one of them against the shift's own standard deviation.
  const double stiffness = shift_sigma > 0.0 ? weights / (count * shift_sigma * shift_sigma) : -1.0;
  Matrix8d H;
  Vector8d g;
  double cost = evaluate(*rig, matches, count, stiffness, *pose, &H, &g);
  if (cost < 0.0) return false;
  double lambda = 1e-3;
  for (int32_t iteration = 0; iteration < max_iterations; ++iteration) {
    if (iteration == kPatience && cost > hopeless_rms * hopeless_rms * weights) return false;
    Matrix8d damped = H;
    damped.diagonal() *= 1.0 + lambda;
    const Eigen::LDLT<Matrix8d> ldlt(damped);
    if (ldlt.info() != Eigen::Success || !ldlt.isPositive()) return false;
    const Vector8d step = -ldlt.solve(g);
    if (!step.allFinite()) return false;
    const Pose trial = {exp_rotation(step.segment<3>(3)) * pose->R, pose->p + step.head<3>()};
    RectRig trial_rig = *rig;
    trial_rig.right_shift += step.tail<2>();
    const double trial_cost = evaluate(trial_rig, matches, count, stiffness, trial, nullptr, nullptr);
    if (trial_cost >= 0.0 && trial_cost <= cost) {
      *pose = trial;
      *rig = trial_rig;
      const bool settled = cost - trial_cost < kSettled * kSettled * count;
      lambda = std::fmax(lambda * 0.1, 1e-9);
      cost = evaluate(*rig, matches, count, stiffness, *pose, &H, &g);
      if (settled) break;
    } else {
      lambda *= 10.0;
      if (lambda > 1e6) break;
    }
  }
  *rms = std::sqrt(cost / weights);
  return true;
}

}  // namespace

bool fit_pose_to_lines(const RectRig& rig, const LineMatch* matches, uint32_t count, int32_t max_iterations,
                       double hopeless_rms, Pose* pose, double* rms) {
  RectRig fixed = rig;
  return fit(&fixed, matches, count, 0.0, max_iterations, hopeless_rms, pose, rms);
}

bool fit_pose_and_shift(RectRig* rig, const LineMatch* matches, uint32_t count, double shift_sigma,
                        int32_t max_iterations, double hopeless_rms, Pose* pose, double* rms) {
  return fit(rig, matches, count, shift_sigma, max_iterations, hopeless_rms, pose, rms);
}

}  // namespace rvdnav
