#include "navigator/edge_samples.hpp"

#include <algorithm>

#include "pose/view_pose.hpp"
#include "sampling.hpp"
#include "status.hpp"
#include "target/visibility.hpp"

namespace rvdnav {
namespace {

// A part of an edge that is shorter than this is not worth a look.
constexpr double kShortestPart = 10.0;  // pixels
// The most that the fit of a step takes; each round may find up to twice the blur of the one before.
constexpr double kLargestBlur = 10.0;  // pixels

// The edges that the views with an image see; those behind the model's are not hidden by its faces.
void find_pieces(const Scene& scene, const math::Transform& T, double depth, EdgeSamples* samples) {
  rvdnav_edge_model model = scene.model();
  if (depth != 0.0) model.face_count = 0;
  samples->piece_count = 0;
  for (int32_t camera = 0; camera < scene.views; ++camera) {
    if (!scene.present[camera]) continue;
    double eye[3];
    eye_in_target(scene.problem->cameras, camera, T, eye);
    samples->piece_count += visible_pieces(model, eye, kGrazing, camera, samples->pieces + samples->piece_count);
  }
}

// Where the pieces are to be measured.  False for one that is not in front of its camera.
bool place_pieces(const Scene& scene, const math::Transform& T, const SampleRequest& request, EdgeSamples* samples) {
  ViewPose views[RVDNAV_CAMERAS];
  for (int32_t camera = 0; camera < scene.views; ++camera) {
    views[camera] = view_pose(scene.problem->cameras, camera, T);
  }
  for (uint32_t i = 0; i < samples->piece_count; ++i) {
    const Piece& piece = samples->pieces[i];
    const int32_t index = scene.index(piece.camera, piece.edge);
    rvdnav_seen_edge& seen = samples->seen[i];
    seen = {};
    seen.camera = piece.camera;
    seen.polarity = request.polarity[index];
    for (int32_t end = 0; end < 2; ++end) {
      const double* p = piece.ends[end];
      const double place[3] = {p[0] + request.depth, p[1], p[2]};
      views[piece.camera].place(place, seen.ends[end]);
      if (!(seen.ends[end][2] > 0.0)) return false;
      if (request.offsets == nullptr) continue;
      const double* offset = request.offsets + 2 * index;
      seen.offset[end] = offset[0] + part_along(scene.model(), piece.edge, p) * (offset[1] - offset[0]);
    }
    if (request.face == nullptr) continue;
    seen.face = request.face[index];
    seen.blur = std::min(request.blur[index], kLargestBlur);
  }
  return true;
}

// How many profiles there were on each edge, and what of it was looked at.  False if nothing was.
bool sum_up(const Scene& scene, EdgeSamples* samples) {
  std::fill(samples->attempted, samples->attempted + scene.size(), 0);
  for (int32_t i = 0; i < scene.size(); ++i) {
    for (int32_t end = 0; end < 2; ++end) {
      const double* p = edge_end(scene.model(), i % scene.edges, end);
      std::copy(p, p + 3, samples->spans + 6 * i + 3 * end);
    }
  }
  bool any = false;
  int32_t last = -1;
  for (uint32_t i = 0; i < samples->piece_count; ++i) {
    if (samples->coverage[i].placed == 0) continue;
    const Piece& piece = samples->pieces[i];
    const int32_t index = scene.index(piece.camera, piece.edge);
    samples->attempted[index] += samples->coverage[i].profiles;
    double* span = samples->spans + 6 * index;
    if (index != last) std::copy(piece.ends[0], piece.ends[0] + 3, span);
    std::copy(piece.ends[1], piece.ends[1] + 3, span + 3);
    last = index;
    any = true;
  }
  return any;
}

void take_points(const Scene& scene, EdgeSamples* samples) {
  std::fill(samples->begin, samples->begin + scene.size() + 1, 0u);
  for (uint32_t i = 0; i < samples->count; ++i) {
    const rvdnav_edge_sample& step = samples->steps[i];
    const Piece& piece = samples->pieces[step.edge];
    samples->points[i] = {piece.camera, piece.edge, step.x, step.y, step.nx, step.ny, step.sigma};
    ++samples->begin[scene.index(piece.camera, piece.edge) + 1];
  }
  for (int32_t i = 0; i < scene.size(); ++i) samples->begin[i + 1] += samples->begin[i];
}

}  // namespace

void lay_out(const rvdnav_edge_model& model, int32_t views, Arena& arena, EdgeSamples* samples) {
  const size_t count = static_cast<size_t>(views), edges = count * model.edge_count;
  const size_t pieces = count * most_pieces(model), steps = pieces * kMostProfiles;
  arena.take(&samples->pieces, pieces);
  arena.take(&samples->seen, pieces);
  arena.take(&samples->coverage, pieces);
  arena.take(&samples->steps, steps);
  arena.take(&samples->points, steps);
  arena.take(&samples->weights, steps);
  arena.take(&samples->begin, edges + 1);
  arena.take(&samples->attempted, edges);
  arena.take(&samples->spans, 6 * edges);
}

rvdnav_status sample_target(const Scene& scene, const math::Transform& T, const SampleRequest& request,
                            EdgeSamples* samples) {
  find_pieces(scene, T, request.depth, samples);
  if (!place_pieces(scene, T, request, samples)) return RVDNAV_ERROR_BEHIND;
  const ProfileSettings settings = {request.half_width, 1.0, scene.blur_sigma};
  const bool in_parts = scene.model().face_count > 0 && request.depth == 0.0;
  samples->count = sample_edges(*scene.rig, scene.images, samples->seen, samples->piece_count,
                                in_parts ? kShortestPart : 0.0, settings, samples->steps, samples->coverage);
  if (!sum_up(scene, samples)) return RVDNAV_ERROR_UNDETERMINED;
  take_points(scene, samples);
  return RVDNAV_OK;
}

}  // namespace rvdnav
