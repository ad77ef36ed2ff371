#include "target/visibility.hpp"

#include <algorithm>
#include <cmath>

namespace rvdnav {
namespace {

constexpr int32_t kPlaces = 65;         // along an edge, at which it is asked whether they are seen
constexpr uint32_t kPiecesPerEdge = 4;  // on the average, that there is room for

double dot_3(const double* a, const double* b) { return a[0] * b[0] + a[1] * b[1] + a[2] * b[2]; }

// One face as an eye in C sees it.
struct SeenFace {
  const double *normal, *origin, *axes, *corners;
  double height;  // of the eye above it, metres
};

SeenFace seen_face(const rvdnav_edge_model& model, uint32_t face, const double* eye) {
  const size_t corners = model.corner_count;
  SeenFace seen = {model.face_normals + 3 * face, model.face_origins + 3 * face, model.face_axes + 6 * face,
                   model.face_corners + 2 * corners * face, 0.0};
  const double from_origin[3] = {eye[0] - seen.origin[0], eye[1] - seen.origin[1], eye[2] - seen.origin[2]};
  seen.height = dot_3(from_origin, seen.normal);
  return seen;
}

// Whether a place (2) in its plane lies within a face: a ray along the first axis crosses an odd number of sides.
bool is_inside(const double* corners, uint32_t count, double x, double y) {
  bool inside = false;
  for (uint32_t i = 0; i < count; ++i) {
    const double* a = corners + 2 * i;
    const double* b = corners + 2 * ((i + 1) % count);
    if ((a[1] > y) == (b[1] > y)) continue;
    if (x < a[0] + (y - a[1]) * (b[0] - a[0]) / (b[1] - a[1])) inside = !inside;
  }
  return inside;
}

// Whether the ray from the eye meets the face before it comes to the place.
bool hides(const rvdnav_edge_model& model, const SeenFace& face, const double* eye, const double* place) {
  const double from_origin[3] = {place[0] - face.origin[0], place[1] - face.origin[1], place[2] - face.origin[2]};
  const double height = dot_3(from_origin, face.normal);
  if (!(height * face.height < 0.0) || std::fabs(height) <= model.touch || std::fabs(face.height) <= model.touch) {
    return false;
  }
  const double part = face.height / (face.height - height);
  double hit[3];
  for (int32_t i = 0; i < 3; ++i) hit[i] = eye[i] + part * (place[i] - eye[i]) - face.origin[i];
  return is_inside(face.corners, model.corner_count, dot_3(hit, face.axes), dot_3(hit, face.axes + 3));
}

// Whether the eye stands high enough above a face for its edges to count.
bool faces_eye(const rvdnav_edge_model& model, const SeenFace& face, const double* eye, double least_elevation) {
  double mean[2] = {};
  for (uint32_t i = 0; i < model.corner_count; ++i) {
    mean[0] += face.corners[2 * i];
    mean[1] += face.corners[2 * i + 1];
  }
  double to_eye[3];
  for (int32_t i = 0; i < 3; ++i) {
    const double middle = face.origin[i] + (mean[0] * face.axes[i] + mean[1] * face.axes[3 + i]) / model.corner_count;
    to_eye[i] = eye[i] - middle;
  }
  return face.height > std::max(least_elevation * std::sqrt(dot_3(to_eye, to_eye)), model.touch);
}

// Whether all faces that the edge lies on look away.
bool looks_away(const rvdnav_edge_model& model, int32_t edge, const double* eye, double least_elevation) {
  const uint8_t* adjoining = model.adjoining + static_cast<size_t>(edge) * model.face_count;
  bool lies_on_one = false;
  for (uint32_t f = 0; f < model.face_count; ++f) {
    if (adjoining[f] == 0) continue;
    lies_on_one = true;
    if (faces_eye(model, seen_face(model, f, eye), eye, least_elevation)) return false;
  }
  return lies_on_one;
}

void place_along(const double* from, const double* to, int32_t k, double* place) {
  const double part = static_cast<double>(k) / (kPlaces - 1);
  for (int32_t i = 0; i < 3; ++i) place[i] = from[i] + part * (to[i] - from[i]);
}

// Which of the places along the edge are seen; how many.
int32_t seen_places(const rvdnav_edge_model& model, int32_t edge, const double* eye, double least_elevation,
                    bool (&seen)[kPlaces]) {
  std::fill(seen, seen + kPlaces, false);
  if (looks_away(model, edge, eye, least_elevation)) return 0;
  int32_t count = 0;
  for (int32_t k = 0; k < kPlaces; ++k) {
    double place[3];
    place_along(edge_end(model, edge, 0), edge_end(model, edge, 1), k, place);
    bool hidden = false;
    for (uint32_t f = 0; f < model.face_count && !hidden; ++f) {
      hidden = hides(model, seen_face(model, f, eye), eye, place);
    }
    seen[k] = !hidden;
    count += hidden ? 0 : 1;
  }
  return count;
}

// The edge from its place first to its place last.
Piece piece_of(const rvdnav_edge_model& model, int32_t edge, int32_t first, int32_t last, int32_t camera) {
  Piece piece;
  piece.edge = edge;
  piece.camera = camera;
  const double *from = edge_end(model, edge, 0), *to = edge_end(model, edge, 1);
  place_along(from, to, first, piece.ends[0]);
  place_along(from, to, last, piece.ends[1]);
  if (first == 0) std::copy(from, from + 3, piece.ends[0]);
  if (last == kPlaces - 1) std::copy(to, to + 3, piece.ends[1]);
  return piece;
}

}  // namespace

uint32_t most_pieces(const rvdnav_edge_model& model) {
  return model.edge_count * (model.face_count == 0 ? 1 : kPiecesPerEdge);
}

uint32_t visible_pieces(const rvdnav_edge_model& model, const double* eye, double least_elevation, int32_t camera,
                        Piece* pieces) {
  const uint32_t most = most_pieces(model);
  uint32_t count = 0;
  for (int32_t edge = 0; edge < static_cast<int32_t>(model.edge_count); ++edge) {
    bool seen[kPlaces];
    if (model.face_count == 0) {
      pieces[count++] = piece_of(model, edge, 0, kPlaces - 1, camera);
      continue;
    }
    if (seen_places(model, edge, eye, least_elevation, seen) == 0) continue;
    for (int32_t first = 0; first < kPlaces; ++first) {
      if (!seen[first]) continue;
      int32_t last = first;
      while (last + 1 < kPlaces && seen[last + 1]) ++last;
      // A single place has no length.
      if (last > first && count < most) pieces[count++] = piece_of(model, edge, first, last, camera);
      first = last;
    }
  }
  return count;
}

}  // namespace rvdnav
