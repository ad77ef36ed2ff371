#include "target/neighbours.hpp"

#include <algorithm>
#include <cmath>

#include "target/visibility.hpp"

namespace rvdnav {
namespace {

// Edges farther apart than this are not confused; profiles reach half as far.
constexpr double kReach = 5.0;  // pixels
// Sine of the angle up to which edges run beside each other.
constexpr double kParallel = 0.25;
constexpr int32_t kPlaces = 9;        // along an edge
constexpr double kFirstPlace = 0.05;  // as a part of it; the last one is as far from the other end
constexpr double kAccompanied = 0.3;  // part of an edge that a neighbour must accompany
constexpr double kTiny = 1e-12;

double square_of(const ProjectedEdge& edge) { return edge.span[0] * edge.span[0] + edge.span[1] * edge.span[1]; }

bool run_alike(const ProjectedEdge& a, const ProjectedEdge& b) {
  const double cross = a.span[0] * b.span[1] - a.span[1] * b.span[0];
  const double lengths = std::max(std::sqrt(square_of(a)), kTiny) * std::max(std::sqrt(square_of(b)), kTiny);
  return std::fabs(cross) < kParallel * lengths;
}

// Mean distance of an edge from another one where it is near; 0 where it doesn't accompany it.
double mean_distance(const ProjectedEdge& edge, const ProjectedEdge& other) {
  double sum = 0.0;
  int32_t near = 0;
  for (int32_t k = 0; k < kPlaces; ++k) {
    const double part = kFirstPlace + k * (1.0 - 2.0 * kFirstPlace) / (kPlaces - 1);
    const double x = edge.start[0] + part * edge.span[0] - other.start[0];
    const double y = edge.start[1] + part * edge.span[1] - other.start[1];
    const double along = (x * other.span[0] + y * other.span[1]) / std::max(square_of(other), kTiny);
    const double dx = x - along * other.span[0], dy = y - along * other.span[1];
    const double distance = std::sqrt(dx * dx + dy * dy);
    if (!(distance < kReach) || along < 0.0 || along > 1.0) continue;
    sum += distance;
    ++near;
  }
  return near >= kAccompanied * kPlaces ? sum / near : 0.0;
}

}  // namespace

bool neighbour_separation(const rvdnav_edge_model& model, const rvdnav_pose_cameras& cameras, int32_t camera,
                          const math::Transform& T, const NeighbourMemory& memory, double* separation) {
  double eye[3];
  eye_in_target(cameras, camera, T, eye);
  const uint32_t pieces = visible_pieces(model, eye, 0.0, camera, memory.pieces);
  const ViewPose view = view_pose(cameras, camera, T);
  std::fill(separation, separation + model.edge_count, 0.0);
  int32_t count = 0;
  for (uint32_t i = 0; i < pieces; ++count) {
    uint32_t last = i;
    while (last + 1 < pieces && memory.pieces[last + 1].edge == memory.pieces[i].edge) ++last;
    if (!project_edge(view, memory.pieces[i].ends[0], memory.pieces[last].ends[1], memory.edges + count)) return false;
    memory.number[count] = memory.pieces[i].edge;
    i = last + 1;
  }
  for (int32_t i = 0; i < count; ++i) {
    double& own = separation[memory.number[i]];
    for (int32_t j = 0; j < count; ++j) {
      if (j == i || !run_alike(memory.edges[i], memory.edges[j])) continue;
      own = std::max(own, mean_distance(memory.edges[i], memory.edges[j]));
    }
  }
  return true;
}

}  // namespace rvdnav
