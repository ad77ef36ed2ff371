#include "bracket_support.hpp"

#include <algorithm>
#include <cmath>

namespace rvdnav {
namespace {

constexpr double kMinOverlap = 6.0;          // pixels
constexpr double kMinOverlapFraction = 0.2;  // of the edge

// An edge of the model as it appears in a view.
struct ProjectedEdge {
  Eigen::Vector2d p;
  Eigen::Vector2d direction;
  double length;
};

ProjectedEdge project_edge(const RectRig& rig, int32_t camera, const BracketModel::Edge& edge, const Pose& pose) {
  ProjectedEdge e;
  e.p = rig.project(camera, pose * edge.a);
  const Eigen::Vector2d d = rig.project(camera, pose * edge.b) - e.p;
  e.length = d.norm();
  e.direction = d / std::max(e.length, 1e-9);
  return e;
}

// The front edge, and the back edge of its side face where that is in sight: the light decides which of them shows.
class VisibleEdges {
 public:
  void add(const BracketModel::Edge& edge) { edges_[count_++] = edge; }
  const BracketModel::Edge* begin() const { return edges_; }
  const BracketModel::Edge* end() const { return edges_ + count_; }

 private:
  BracketModel::Edge edges_[2];
  int32_t count_ = 0;
};

VisibleEdges visible_edges(const RectRig& rig, const BracketModel& model, int32_t camera, const Pose& pose, int32_t k) {
  VisibleEdges edges;
  const BracketModel::Edge& front = model.edge[k];
  edges.add(front);
  const Eigen::Vector3d to_camera = rig.centre(camera) - pose * (0.5 * (front.a + front.b));
  if ((pose.R * model.outward[k]).dot(to_camera) > 0.0) edges.add({front.a + model.back, front.b + model.back});
  return edges;
}

struct Overlap {
  double low, high;  // along the edge, pixels from its start
  double distance;   // across it in the middle
  int32_t polarity;  // of the segment, seen along the edge
  double closeness;  // 1 on the edge .. 0 at the tolerance, over the length of the part
};

// The part of a segment that lies along an edge; false when it is too far off.
bool overlap_with(const ProjectedEdge& edge, const rvdnav_segment& s, const Line2& line, const Tolerance& tolerance,
                  Overlap* out) {
  const double sine = edge.direction.dot(line.normal);
  if (std::abs(sine) > tolerance.angle) return false;
  const double start = line.distance(edge.p);
  // Quick rejection by the distance between the lines at the edge's middle.
  if (std::abs(start + 0.5 * edge.length * sine) > tolerance.distance + 0.5 * edge.length * std::abs(sine))
    return false;
  double low = edge.direction.dot(line.at(s.t_min) - edge.p);
  double high = edge.direction.dot(line.at(s.t_max) - edge.p);
  if (low > high) std::swap(low, high);
  low = std::max(low, 0.0);
  high = std::min(high, edge.length);
  if (high <= low) return false;
  out->low = low;
  out->high = high;
  out->distance = start + 0.5 * (low + high) * sine;
  // The normal (-dy, dx) of the edge against the segment's.
  const double facing = edge.direction.x() * line.normal.y() - edge.direction.y() * line.normal.x();
  out->polarity = facing > 0.0 ? s.polarity : -s.polarity;
  // Mean square of the distance along the part: that of its middle and of its slope.
  const double slope = (high - low) * sine;
  const double square =
      (out->distance * out->distance + slope * slope / 12.0) / (tolerance.distance * tolerance.distance);
  out->closeness = 1.0 - square;
  return square < 1.0;
}

}  // namespace

uint32_t match_edges(const RectRig& rig, const BracketModel& model, int32_t camera, const ViewSegments& view,
                     const Pose& pose, const Tolerance& tolerance, LineMatch* matches) {
  uint32_t n = 0;
  for (int32_t k = 0; k < RVDNAV_EDGES; ++k) {
    double best = 0.0;
    for (const BracketModel::Edge& candidate : visible_edges(rig, model, camera, pose, k)) {
      const ProjectedEdge edge = project_edge(rig, camera, candidate, pose);
      for (uint32_t i = 0; i < view.count; ++i) {
        Overlap o;
        if (!overlap_with(edge, view.segments[i], view.lines[i], tolerance, &o)) continue;
        const double length = o.high - o.low;
        if (length < std::max(kMinOverlap, kMinOverlapFraction * edge.length)) continue;
        const double quality = length * o.closeness;
        if (quality <= best) continue;
        best = quality;
        const Eigen::Vector3d span = candidate.b - candidate.a;
        matches[n] = {camera,
                      k,
                      o.polarity,
                      view.lines[i],
                      length,
                      candidate.a + span * (o.low / edge.length),
                      candidate.a + span * (o.high / edge.length)};
      }
    }
    if (best > 0.0) ++n;
  }
  return n;
}

EdgeSupport edge_support(const RectRig& rig, const BracketModel& model, int32_t camera, const ViewSegments& view,
                         const Pose& pose, const Tolerance& tolerance) {
  EdgeSupport support = {};
  for (int32_t k = 0; k < RVDNAV_EDGES; ++k) {
    for (const BracketModel::Edge& candidate : visible_edges(rig, model, camera, pose, k)) {
      const ProjectedEdge edge = project_edge(rig, camera, candidate, pose);
      double covered[2] = {};
      for (uint32_t i = 0; i < view.count; ++i) {
        Overlap o;
        if (overlap_with(edge, view.segments[i], view.lines[i], tolerance, &o))
          covered[o.polarity > 0 ? 1 : 0] += (o.high - o.low) * o.closeness;
      }
      support.length[k] = edge.length;
      for (int32_t p = 0; p < 2; ++p)
        support.covered[k][p] = std::max(support.covered[k][p], std::min(covered[p] / std::max(edge.length, 1.0), 1.0));
    }
  }
  return support;
}

CombinedSupport combine(const EdgeSupport* views, int32_t view_count) {
  CombinedSupport combined = {};
  double sum = 0.0;
  double total = 0.0;
  for (int32_t k = 0; k < RVDNAV_EDGES; ++k) {
    double by_polarity[2] = {};
    double fraction[2] = {};
    for (int32_t v = 0; v < view_count; ++v) {
      total += views[v].length[k];
      for (int32_t p = 0; p < 2; ++p) {
        by_polarity[p] += views[v].covered[k][p] * views[v].length[k];
        fraction[p] += views[v].covered[k][p] / view_count;
      }
    }
    sum += std::max(by_polarity[0], by_polarity[1]);
    combined.covered[k] = std::max(fraction[0], fraction[1]);
  }
  combined.fraction = total > 0.0 ? sum / total : 0.0;
  return combined;
}

}  // namespace rvdnav
