#include "bracket_propose.hpp"

#include <algorithm>
#include <cmath>

#include <Eigen/Geometry>

#include "math/elementary.hpp"

namespace rvdnav {
namespace {

constexpr double kMinCornerAngle = 0.35;  // between adjoining bars in the image, radians
constexpr uint32_t kMaxNeighbours = 24;   // at one end of a bar
constexpr double kWidthRatio = 2.0;       // between adjoining bars, and between seen and expected width
constexpr double kMaxLength = 1.8;        // seen over expected
constexpr double kMaxFitRms = 2.5;        // pixels, of the six lines
constexpr double kHopelessRms = 12.0;     // pixels, after a few iterations
constexpr double kMaxTilt = 1.31;         // of the face against the line of sight, radians (75 degrees)
constexpr double kMinProposalSupport = 0.35;
constexpr int32_t kFitIterations = 10;
constexpr double kDistinctNormal = 0.05;  // between the normals of a pose and its mirror image
constexpr double kMaxShear = 0.7;         // of a corner's angle by perspective and tilt, radians
constexpr Tolerance kSupportTolerance = {2.5, 0.09};

// Keeps the best proposals in the caller's array.
class ProposalList {
 public:
  ProposalList(Proposal* items, uint32_t capacity) : items_(items), capacity_(capacity) {}

  void add(const Proposal& proposal) {
    for (uint32_t i = 0; i < count_; ++i) {
      if (!nearly_equal(items_[i].pose, proposal.pose)) continue;
      // Which of the two stays can change the order of the heap; with so few items it is made anew.
      if (better(proposal, items_[i])) {
        items_[i] = proposal;
        std::make_heap(items_, items_ + count_, better);
      }
      return;
    }
    if (count_ < capacity_) {
      items_[count_++] = proposal;
      std::push_heap(items_, items_ + count_, better);
      return;
    }
    overflowed_ = true;
    if (capacity_ == 0 || !better(proposal, items_[0])) return;
    std::pop_heap(items_, items_ + count_, better);
    items_[count_ - 1] = proposal;
    std::push_heap(items_, items_ + count_, better);
  }

  void sort() { std::sort_heap(items_, items_ + count_, better); }
  uint32_t count() const { return count_; }
  bool overflowed() const { return overflowed_; }

 private:
  static bool better(const Proposal& a, const Proposal& b) {
    return a.support != b.support ? a.support > b.support : a.pose.p.z() < b.pose.p.z();
  }

  // Closer than the search over both views will pull them together.
  static bool nearly_equal(const Pose& a, const Pose& b) {
    constexpr double kSameDistance = 0.01;  // of the range
    constexpr double kSameTurn = 0.03;      // Frobenius norm, about sqrt(2) times the angle
    return (a.p - b.p).squaredNorm() < kSameDistance * kSameDistance * a.p.squaredNorm() &&
           (a.R - b.R).squaredNorm() < kSameTurn * kSameTurn;
  }

  Proposal* items_;
  uint32_t capacity_;
  uint32_t count_ = 0;
  bool overflowed_ = false;
};

struct Neighbour {
  uint32_t bar;
  Eigen::Vector2d corner;  // where the centre lines meet
  int32_t side;            // of the middle bar's line on which it lies, by the sign of the distance
};

struct Axis {
  Line2 line;
  double t_min, t_max;
};

Axis axis_of(const rvdnav_bar& bar) { return {Line2::from_angle(bar.rho, bar.theta), bar.t_min, bar.t_max}; }

// How far a bar's seen end may lie from its true corner.
double reach(const rvdnav_bar& bar) { return 4.0 + 1.5 * bar.width + 0.1 * (bar.t_max - bar.t_min); }

bool adjoins(const rvdnav_bar& middle, bool at_max, const rvdnav_bar& other, Neighbour* out) {
  if (other.width > kWidthRatio * middle.width || middle.width > kWidthRatio * other.width) return false;
  if (std::abs(line_angle_difference(other.theta, middle.theta)) < kMinCornerAngle) return false;
  const Axis m = axis_of(middle);
  const Axis o = axis_of(other);
  Eigen::Vector2d corner;
  if (!intersect(m.line, o.line, 0.3, &corner)) return false;
  const double tm = m.line.direction().dot(corner);
  if (std::abs(tm - (at_max ? m.t_max : m.t_min)) > reach(middle)) return false;
  const double to = o.line.direction().dot(corner);
  const bool from_min = std::abs(to - o.t_min) < std::abs(to - o.t_max);
  if (std::abs(to - (from_min ? o.t_min : o.t_max)) > reach(other)) return false;
  out->corner = corner;
  out->side = m.line.distance(o.line.at(from_min ? o.t_max : o.t_min)) > 0.0 ? 1 : -1;
  return true;
}

uint32_t find_neighbours(const ViewBars& view, uint32_t middle, bool at_max, Neighbour* out) {
  uint32_t n = 0;
  for (uint32_t i = 0; i < view.count && n < kMaxNeighbours; ++i) {
    if (i == middle || !adjoins(view.bars[middle], at_max, view.bars[i], &out[n])) continue;
    out[n++].bar = i;
  }
  return n;
}

// A bar's outer or inner line; the inner one lies nearer to a point inside the frame.
Line2 side_line(const ViewBars& view, uint32_t bar, bool outer, const Eigen::Vector2d& inside) {
  const rvdnav_bar& b = view.bars[bar];
  const Line2 axis = Line2::from_angle(b.rho, b.theta);
  const bool inside_above = axis.distance(inside) > 0.0;  // towards growing rho, where the second segment lies
  return view.segments.lines[b.segment[inside_above != outer ? 1 : 0]];
}

// Three adjoining bars in the order around the frame, read as previous, k and next bar of the bracket.
struct Reading {
  uint32_t bar[3];
  Eigen::Vector2d start, end;  // corners of the middle bar
};

bool plausible(const ViewBars& view, const Reading& r, const BracketModel& model, int32_t k, double pixels_per_metre) {
  const int32_t bars[3] = {kPreviousBar[k], k, kNextBar[k]};
  for (int32_t i = 0; i < 3; ++i) {
    const rvdnav_bar& seen = view.bars[r.bar[i]];
    const double width = model.bar_width[bars[i]] * pixels_per_metre;
    const double length = (model.axis_end[bars[i]] - model.axis_start[bars[i]]).norm() * pixels_per_metre;
    // Tilt shortens a bar's width or length; the scale comes from the middle bar, which tilt may have shortened too.
    if (seen.width > kWidthRatio * width || seen.width < width / kWidthRatio) return false;
    const double seen_length = seen.t_max - seen.t_min;
    if (seen_length > kMaxLength * length + seen.width || seen_length < 0.25 * length) return false;
  }
  // The corners' angles, up to what tilt can do to them.
  for (int32_t i = 0; i < 3; i += 2) {
    const Eigen::Vector3d a = model.axis_end[k] - model.axis_start[k];
    const Eigen::Vector3d b = model.axis_end[bars[i]] - model.axis_start[bars[i]];
    // Angle of the bar's line against the middle one's, drawn as (-z_C, y_C).
    const double expected = math::atan2(b.y(), -b.z()) - math::atan2(a.y(), -a.z());
    const double found = view.bars[r.bar[i]].theta - view.bars[r.bar[1]].theta;
    if (std::abs(line_angle_difference(found, expected)) > kMaxShear) return false;
  }
  return true;
}

// The shortest turn that takes one unit vector to another one, not opposite to it (Rodrigues' formula; Eigen's own way
// over a quaternion brings a singular value decomposition into the core).
Eigen::Matrix3d turn_between(const Eigen::Vector3d& from, const Eigen::Vector3d& to) {
  const Eigen::Vector3d v = from.cross(to);
  Eigen::Matrix3d K;
  K << 0, -v.z(), v.y(),  //
      v.z(), 0, -v.x(),   //
      -v.y(), v.x(), 0;
  return Eigen::Matrix3d::Identity() + K + K * K / (1.0 + from.dot(to));
}

Pose facing_pose(const RectRig& rig, int32_t camera, const BracketModel& model, int32_t k, const Reading& r,
                 double pixels_per_metre) {
  const Eigen::Vector3d along = (model.axis_end[k] - model.axis_start[k]).normalized();
  const Eigen::Vector2d seen = (r.end - r.start).normalized();
  // Facing the camera, (y_C, z_C) appears as (-z_C, y_C) in the image, turned by the roll about the line of sight.
  const Eigen::Vector2d drawn(-along.z(), along.y());
  const double c = drawn.dot(seen);
  const double s = drawn.x() * seen.y() - drawn.y() * seen.x();
  Eigen::Matrix3d facing;  // columns: x_C, y_C, z_C in R
  facing << 0, 0, -1,      //
      0, 1, 0,             //
      1, 0, 0;
  Eigen::Matrix3d roll;
  roll << c, -s, 0,  //
      s, c, 0,       //
      0, 0, 1;
  // Turn so that the face looks at the camera rather than along its axis.
  const Eigen::Vector2d middle = 0.5 * (r.start + r.end);
  const Eigen::Vector3d ray(middle.x() / rig.focal, middle.y() / rig.focal, 1.0);
  const Eigen::Matrix3d turn = turn_between(Eigen::Vector3d::UnitZ(), ray.normalized());
  Pose pose;
  pose.R = turn * roll * facing;
  pose.p = rig.centre(camera) + ray * (rig.focal / pixels_per_metre) -
           pose.R * (0.5 * (model.axis_start[k] + model.axis_end[k]));
  return pose;
}

// The pose whose face is tilted the opposite way about the line of sight.
Pose mirrored(const RectRig& rig, int32_t camera, const Pose& pose, const Eigen::Vector3d& centre_C) {
  const Eigen::Vector3d centre = pose * centre_C;
  const Eigen::Vector3d sight = (centre - rig.centre(camera)).normalized();
  const Eigen::Vector3d normal = pose.R.col(0);
  const Eigen::Vector3d reflected = 2.0 * normal.dot(sight) * sight - normal;
  const Eigen::Matrix3d turn = turn_between(normal, reflected);
  Pose out;
  out.R = turn * pose.R;
  out.p = centre - out.R * centre_C;
  return out;
}

bool sensible(const RectRig& rig, int32_t camera, const Pose& pose, const RangeGate& gate) {
  if (!gate.admits(pose)) return false;
  const Eigen::Vector3d sight = (pose.p - rig.centre(camera)).normalized();
  return pose.R.col(0).dot(sight) > math::cos(kMaxTilt);
}

// Returns whether the reading was plausible enough to be tried.
bool try_reading(const RectRig& rig, const BracketModel& model, int32_t camera, const ViewBars& view, const Reading& r,
                 int32_t k, const RangeGate& gate, ProposalList* list) {
  const double pixels_per_metre = (r.end - r.start).norm() / (model.axis_end[k] - model.axis_start[k]).norm();
  const double depth = rig.focal / pixels_per_metre;
  if (depth < 0.5 * gate.min || depth > 2.0 * gate.max || !plausible(view, r, model, k, pixels_per_metre)) return false;

  const int32_t bars[3] = {kPreviousBar[k], k, kNextBar[k]};
  Eigen::Vector2d inside = 0.5 * (r.start + r.end);
  {
    const Eigen::Vector2d along = r.end - r.start;
    inside += 0.2 * Eigen::Vector2d(-along.y(), along.x());
  }
  LineMatch matches[6];
  for (int32_t i = 0; i < 3; ++i) {
    for (int32_t side = 0; side < 2; ++side) {
      const int32_t edge = 2 * bars[i] + side;
      matches[2 * i + side] = {
          camera, edge, 0, side_line(view, r.bar[i], side == 0, inside), 1.0, model.edge[edge].a, model.edge[edge].b};
    }
  }
  const auto propose = [&](const Pose& pose, double rms) {
    if (rms > kMaxFitRms || !sensible(rig, camera, pose, gate)) return;
    const EdgeSupport support = edge_support(rig, model, camera, view.segments, pose, kSupportTolerance);
    const double fraction = combine(&support, 1).fraction;
    if (fraction >= kMinProposalSupport) list->add({pose, fraction, camera});
  };
  Pose pose = facing_pose(rig, camera, model, k, r, pixels_per_metre);
  double rms = 0.0;
  if (!fit_pose_to_lines(rig, matches, 6, kFitIterations, kHopelessRms, &pose, &rms) || rms > kMaxFitRms) return true;
  propose(pose, rms);
  Pose other = mirrored(rig, camera, pose, 0.5 * (model.axis_start[k] + model.axis_end[k]));
  if (!fit_pose_to_lines(rig, matches, 6, kFitIterations, kHopelessRms, &other, &rms)) return true;
  if ((other.R.col(0) - pose.R.col(0)).norm() > kDistinctNormal) propose(other, rms);
  return true;
}

}  // namespace

double max_slenderness(const BracketModel& model) {
  double longest = 0.0;
  for (int32_t k = 0; k < RVDNAV_BARS; ++k) {
    const double length = (model.axis_end[k] - model.axis_start[k]).norm();
    longest = std::max(longest, length / model.bar_width[k]);
  }
  return kMaxLength * kWidthRatio * longest + 1.0;
}

uint32_t propose_brackets(const RectRig& rig, const BracketModel& model, int32_t camera, const ViewBars& view,
                          const RangeGate& gate, uint32_t max_readings, Proposal* proposals, uint32_t capacity,
                          bool* limited) {
  ProposalList list(proposals, capacity);
  Neighbour low[kMaxNeighbours];
  Neighbour high[kMaxNeighbours];
  uint32_t readings = 0;
  for (uint32_t m = 0; m < view.count && readings < max_readings; ++m) {
    const uint32_t low_count = find_neighbours(view, m, false, low);
    if (low_count == 0) continue;
    const uint32_t high_count = find_neighbours(view, m, true, high);
    for (uint32_t i = 0; i < low_count; ++i) {
      for (uint32_t j = 0; j < high_count; ++j) {
        if (low[i].side != high[j].side || low[i].bar == high[j].bar) continue;
        // Walked around in the order P1, P2, P3, P4, the frame has its inside at (-dy, dx); a line's normal points the
        // other way when walked towards growing t.
        const bool forward = low[i].side < 0;
        const Neighbour& first = forward ? low[i] : high[j];
        const Neighbour& second = forward ? high[j] : low[i];
        const Reading r = {{first.bar, m, second.bar}, first.corner, second.corner};
        for (int32_t k = 0; k < RVDNAV_BARS && readings < max_readings; ++k) {
          if (try_reading(rig, model, camera, view, r, k, gate, &list)) ++readings;
        }
      }
    }
  }
  list.sort();
  *limited = readings >= max_readings || list.overflowed();
  return list.count();
}

}  // namespace rvdnav
