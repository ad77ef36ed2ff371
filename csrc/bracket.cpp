#include "bracket.hpp"

#include <algorithm>
#include <cmath>

#include <Eigen/Geometry>

#include "math/elementary.hpp"

namespace rvdnav {
namespace {

// Segments are gathered ever closer to the pose that the last ones gave.
constexpr Tolerance kRounds[] = {{5.0, 0.12}, {3.0, 0.08}, {2.0, 0.06}, {1.5, 0.05}};
// Support is counted at two tolerances, so that a pose that fits closely beats one that is merely near.
constexpr Tolerance kNear = {1.3, 0.06};
constexpr Tolerance kClose = {0.65, 0.04};
constexpr uint32_t kMinMatches = 6;     // edges with a line, over both views
constexpr double kEdgeSupported = 0.4;  // covered part from which an edge counts as seen
constexpr int32_t kMinEdges = 6;        // of the 8, in either view
constexpr double kMinScore = 0.5;
constexpr double kMinViewScore = 0.35;
constexpr double kMaxRms = 1.2;           // pixels
constexpr double kHopelessRms = 6.0;      // pixels
constexpr double kAmbiguousRatio = 0.92;  // runner-up to best
// All distances are multiplied by it where nothing was found: a bracket or rig that is not quite what the files say, or a
// blurred or distorted image.
constexpr double kLooseness = 2.5;
// How far the right view may then lie off, pixels: a calibration by hand.
constexpr double kShiftSigma = 5.0;
constexpr double kSameDistance = 0.03;    // of the range, between poses taken for the same
constexpr double kSameAngle = 0.18;       // radians
constexpr double kSameImage = 4.0;        // pixels, between the corners of two poses

struct Candidate {
  Pose pose;
  Eigen::Vector2d right_shift;
  double score;
  bool usable;
};

// An edge found with its bright side on opposite sides in the two views was mistaken in one: the shorter line goes.
uint32_t drop_contradictions(LineMatch* matches, uint32_t left_count, uint32_t count) {
  for (uint32_t i = 0; i < left_count; ++i) {
    for (uint32_t j = left_count; j < count; ++j) {
      if (matches[i].edge != matches[j].edge || matches[i].polarity == matches[j].polarity) continue;
      matches[matches[i].weight < matches[j].weight ? i : j].weight = 0.0;
    }
  }
  return static_cast<uint32_t>(
      std::remove_if(matches, matches + count, [](const LineMatch& m) { return m.weight <= 0.0; }) - matches);
}

struct ViewsSupport {
  CombinedSupport both;
  double least;  // fraction in the view that shows the least
};

ViewsSupport support_of(const RectRig& rig, const BracketModel& model, const ViewSegments views[2],
                        const bool present[2], const Pose& pose, const Tolerance& tolerance) {
  EdgeSupport support[2];
  int32_t count = 0;
  double least = 1.0;
  for (int32_t camera = 0; camera < 2; ++camera) {
    if (!present[camera]) continue;
    support[count] = edge_support(rig, model, camera, views[camera], pose, tolerance);
    least = std::min(least, combine(&support[count++], 1).fraction);
  }
  return {combine(support, count), least};
}

Tolerance times(const Tolerance& tolerance, double factor) { return {factor * tolerance.distance, tolerance.angle}; }

Candidate verify(const RectRig& calibrated, const BracketModel& model, const ViewSegments views[2], const bool present[2],
                 const Proposal& proposal, double looseness) {
  Candidate c = {proposal.pose, Eigen::Vector2d::Zero(), 0.0, false};
  RectRig rig = calibrated;
  const double shift_sigma = looseness > 1.0 && present[0] && present[1] ? kShiftSigma : 0.0;
  LineMatch matches[2 * RVDNAV_EDGES];
  double rms = 0.0;
  for (const Tolerance& tolerance : kRounds) {
    uint32_t n = 0;
    uint32_t left_count = 0;
    for (int32_t camera = 0; camera < 2; ++camera) {
      if (present[camera])
        n += match_edges(rig, model, camera, views[camera], c.pose, times(tolerance, looseness), matches + n);
      if (camera == 0) left_count = n;
    }
    n = drop_contradictions(matches, left_count, n);
    if (n < kMinMatches || !fit_pose_and_shift(&rig, matches, n, shift_sigma, 10, looseness * kHopelessRms, &c.pose, &rms))
      return c;
  }
  c.right_shift = rig.right_shift;
  const ViewsSupport near = support_of(rig, model, views, present, c.pose, times(kNear, looseness));
  const ViewsSupport close = support_of(rig, model, views, present, c.pose, times(kClose, looseness));
  int32_t seen = 0;
  for (double covered : near.both.covered) seen += covered >= kEdgeSupported ? 1 : 0;
  c.score = 0.5 * (near.both.fraction + close.both.fraction);
  c.usable = rms <= looseness * kMaxRms && seen >= kMinEdges && near.least >= kMinViewScore && c.score >= kMinScore;
  return c;
}

bool same_pose(const Pose& a, const Pose& b) {
  // The Frobenius norm of a difference of rotations is sqrt(8) times the sine of half the angle between them.
  const double turn = std::sqrt(8.0) * math::sin(0.5 * kSameAngle);
  return (a.p - b.p).norm() < kSameDistance * a.p.norm() && (a.R - b.R).norm() < turn;
}

// One view can hardly tell a pose from its mirror image about the line of sight; which of them it is, the refinement
// decides.  Poses that put every corner in the same place are therefore no rivals there.
bool same_image(const RectRig& rig, const BracketModel& model, int32_t camera, const Pose& a, const Pose& b) {
  for (const BracketModel::Edge& edge : model.edge) {
    if ((rig.project(camera, a * edge.a) - rig.project(camera, b * edge.a)).norm() > kSameImage) return false;
  }
  return true;
}

rvdnav_bracket choose(const RectRig& rig, const BracketModel& model, const ViewSegments views[2], const bool present[2],
                      const RangeGate& gate, const Proposal* proposals, uint32_t proposal_count, double looseness,
                      Eigen::Vector2d* right_shift) {
  rvdnav_bracket result = {};
  Candidate best = {
      {Eigen::Matrix3d::Identity(), Eigen::Vector3d::Zero()}, Eigen::Vector2d::Zero(), 0.0, false};
  Candidate second = best;
  const auto no_rivals = [&](const Pose& a, const Pose& b) {
    if (present[0] && present[1]) return same_pose(a, b);
    return same_pose(a, b) || same_image(rig, model, present[0] ? 0 : 1, a, b);
  };
  for (uint32_t i = 0; i < proposal_count; ++i) {
    const Candidate c = verify(rig, model, views, present, proposals[i], looseness);
    if (!c.usable || !gate.admits(c.pose)) continue;
    if (!best.usable) {
      best = c;
    } else if (no_rivals(best.pose, c.pose)) {
      if (c.score > best.score) best = c;
    } else if (c.score > best.score) {
      second = best;
      best = c;
    } else if (!second.usable || c.score > second.score) {
      second = c;
    }
  }
  result.hypotheses = proposal_count;
  if (!best.usable) return result;
  result.score = best.score;
  result.runner_up = second.usable && !no_rivals(best.pose, second.pose) ? second.score : 0.0;
  result.ambiguous = result.runner_up > kAmbiguousRatio * result.score ? 1 : 0;
  result.found = result.ambiguous == 0 ? 1 : 0;
  *right_shift = best.right_shift;
  const Eigen::Matrix3d R_W_C = R_world_rect() * best.pose.R;
  const Eigen::Vector3d p_W = R_world_rect() * best.pose.p;
  for (int32_t i = 0; i < 3; ++i) {
    result.p_W[i] = p_W(i);
    for (int32_t j = 0; j < 3; ++j) result.R_W_C[3 * i + j] = R_W_C(i, j);
  }
  return result;
}

}  // namespace

rvdnav_bracket acquire_bracket(const RectRig& rig, const BracketModel& model, const ViewSegments views[2],
                               const bool present[2], const RangeGate& gate, const Proposal* proposals,
                               uint32_t proposal_count, Eigen::Vector2d* right_shift, bool* loose) {
  right_shift->setZero();
  *loose = false;
  const rvdnav_bracket exact = choose(rig, model, views, present, gate, proposals, proposal_count, 1.0, right_shift);
  if (exact.found != 0) return exact;
  const rvdnav_bracket wider =
      choose(rig, model, views, present, gate, proposals, proposal_count, kLooseness, right_shift);
  *loose = wider.found != 0;
  return *loose ? wider : exact;
}

}  // namespace rvdnav
