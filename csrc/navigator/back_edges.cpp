#include "navigator/back_edges.hpp"

#include <algorithm>
#include <cmath>

#include "navigator/constants.hpp"
#include "pose/view_pose.hpp"
#include "status.hpp"
#include "target/side_faces.hpp"

namespace rvdnav {
namespace {

// A back edge nearer to the front edge than this cannot be told from it.
constexpr double kMinSeparation = 2.0;  // pixels
constexpr double kHalfWidth = 2.0;      // pixels
// How far a back edge's line may lie off; the thickness is less exactly known than the front face.
constexpr double kMaxOffset = 1.0;  // pixels
// Coverage from which the front edge speaks for itself.
constexpr double kWhole = 0.5;

// Whether an edge of a view with an image lacks evidence that its back edge may give.  False status for one that is not
// in front of the camera.
rvdnav_status find_wanted(const Scene& scene, const math::Transform& T, const rvdnav_edge_evidence* evidence,
                          int32_t* wanted, bool* any) {
  std::fill(wanted, wanted + scene.size(), 0);
  *any = false;
  for (int32_t camera = 0; camera < scene.views; ++camera) {
    if (!scene.present[camera]) continue;
    const ViewPose view = view_pose(scene.problem->cameras, camera, T);
    for (int32_t e = 0; e < scene.edges; ++e) {
      const int32_t index = scene.index(camera, e);
      const rvdnav_edge_evidence& own = evidence[index];
      if (!(own.agreed < kWhole * std::max<int32_t>(own.attempted, 1))) continue;
      ProjectedEdge edge;
      double separation = 0.0;
      if (!project_edge(view, edge_end(scene.model(), e, 0), edge_end(scene.model(), e, 1), &edge) ||
          !side_separation(scene.model(), view, e, edge.normal, &separation)) {
        return RVDNAV_ERROR_BEHIND;
      }
      wanted[index] = std::fabs(separation) > kMinSeparation ? 1 : 0;
      *any = *any || wanted[index] != 0;
    }
  }
  return RVDNAV_OK;
}

}  // namespace

rvdnav_status add_back_edges(const Scene& scene, const math::Transform& T, MeasuringMemory* memory,
                             rvdnav_edge_evidence* evidence) {
  int32_t wanted[RVDNAV_CAMERAS * RVDNAV_EDGES];
  int32_t either[RVDNAV_CAMERAS * RVDNAV_EDGES] = {};
  bool any = false;
  RVDNAV_TRY(find_wanted(scene, T, evidence, wanted, &any));
  if (!any) return RVDNAV_OK;
  EdgeSamples& samples = memory->beside;
  const double depth = scene.model().thickness;
  const SampleRequest request = {kHalfWidth, either, nullptr, nullptr, nullptr, depth};
  RVDNAV_TRY(sample_target(scene, T, request, &samples));
  uint32_t total = 0;
  const uint32_t found = fit_edge_lines(samples.points, samples.count, memory->fit, memory->beside_fits,
                                        static_cast<uint32_t>(scene.size()), samples.weights, &total);
  for (uint32_t i = 0; i < found; ++i) {
    const rvdnav_edge_line& fit = memory->beside_fits[i];
    const int32_t index = scene.index(fit.camera, fit.edge);
    double distances[2];
    if (!end_distances(scene, T, fit, samples.spans + 6 * index, depth, distances)) return RVDNAV_ERROR_BEHIND;
    if (wanted[index] == 0 || std::max(std::fabs(distances[0]), std::fabs(distances[1])) >= kMaxOffset) continue;
    const auto covered =
        std::count_if(samples.weights + samples.begin[index], samples.weights + samples.begin[index + 1],
                      [](double weight) { return weight > kTrusted; });
    evidence[index].back_coverage = static_cast<double>(covered) / std::max<int32_t>(samples.attempted[index], 1);
  }
  return RVDNAV_OK;
}

}  // namespace rvdnav
