#include "join.hpp"

#include <Eigen/Geometry>

#include "bracket.hpp"
#include "bracket_support.hpp"
#include "epipolar.hpp"
#include "expect.hpp"
#include "stage_clock.hpp"
#include "triangulate.hpp"
#include "view.hpp"

namespace rvdnav {
namespace {

// Windows around an acquired pose: the segments behind it are good to about a pixel.
constexpr double kAcquiredHalfRho = 2.5;      // pixels
constexpr double kAcquiredHalfTheta = 0.035;  // radians
constexpr Tolerance kAcquired = {4.0, 0.06};  // pixels, sine: of a segment that is taken for an edge
// Points correlated on each bar's face, evenly spread between its corners.
constexpr int32_t kPointsPerBar = 4;
static_assert(kPointsPerBar * RVDNAV_BARS <= RVDNAV_MAX_MATCHES, "more points than results");

Pose pose_of(const rvdnav_bracket& bracket) {
  Eigen::Matrix3d R_W_C;
  for (int32_t i = 0; i < 3; ++i)
    R_W_C.row(i) << bracket.R_W_C[3 * i], bracket.R_W_C[3 * i + 1], bracket.R_W_C[3 * i + 2];
  const Eigen::Matrix3d R_rect_world = R_world_rect().transpose();
  return {R_rect_world * R_W_C, R_rect_world * Eigen::Vector3d(bracket.p_W[0], bracket.p_W[1], bracket.p_W[2])};
}

// Where a segment lies along an edge, within what a bracket or a rig that is a little off allows, the window is put
// around that.
void centre_on_segments(const RectRig& rig, const BracketModel& model, int32_t camera, const ViewSegments& segments,
                        const Pose& pose, rvdnav_window* windows, uint32_t n) {
  LineMatch matches[RVDNAV_EDGES];
  const uint32_t found = match_edges(rig, model, camera, segments, pose, kAcquired, matches);
  for (uint32_t i = 0; i < found; ++i) {
    const BracketModel::Edge& front = model.edge[matches[i].edge];
    const Eigen::Vector3d along = front.b - front.a;
    const bool behind = (matches[i].from - front.a).cross(along).norm() > 1e-9 * along.squaredNorm();
    for (uint32_t k = 0; k < n && !behind; ++k) {
      if (windows[k].edge != matches[i].edge) continue;
      // Signed along the window's normal, in the middle of the edge.
      const Line2 expected = Line2::from_angle(windows[k].rho, windows[k].theta);
      const Eigen::Vector2d middle = expected.at(0.5 * (windows[k].t_min + windows[k].t_max));
      const double facing = expected.normal.dot(matches[i].line.normal) > 0.0 ? 1.0 : -1.0;
      windows[k].rho -= facing * matches[i].line.distance(middle);
    }
  }
}

void acquire_from_views(Context& c, const GreyView* images[2], rvdnav_frame_result* result) {
  ViewSegments segments[2] = {};
  bool present[2] = {};
  uint32_t count = 0;
  for (int32_t camera = 0; camera < 2; ++camera) {
    present[camera] = images[camera] != nullptr;
    if (!present[camera]) continue;
    const Workspace& work = c.work[camera];
    segments[camera] = {work.segments, work.segment_lines, work.segment_count};
    for (uint32_t i = 0; i < work.proposal_count; ++i) c.proposals[count++] = work.proposals[i];
  }
  RectRig rig = rect_rig(c.rig);
  Eigen::Vector2d right_shift;
  bool loose = false;
  result->bracket = acquire_bracket(rig, c.model, segments, present, {c.config.range_min, c.config.range_max},
                                    c.proposals, count, &right_shift, &loose);
  if (result->bracket.found == 0) return;
  const Pose pose = pose_of(result->bracket);
  rig.right_shift = right_shift;
  for (int32_t camera = 0; camera < 2; ++camera) {
    if (!present[camera]) continue;
    rvdnav_window windows[RVDNAV_EDGES];
    const uint32_t n = expect_edges(rig, c.model, camera, pose, kAcquiredHalfRho, kAcquiredHalfTheta, windows);
    if (loose) centre_on_segments(rig, c.model, camera, segments[camera], pose, windows, n);
    track_lines(c, camera, *images[camera], windows, n, &result->view[camera]);
  }
}

// Points on the face of every bar whose corners are known in the left view: half-way between outer and inner apex.
uint32_t choose_points(const rvdnav_view_result& left, rvdnav_match* matches) {
  uint32_t n = 0;
  for (int32_t bar = 0; bar < RVDNAV_BARS; ++bar) {
    const uint32_t start = 1U << kStartApex[bar] | 16U << kStartApex[bar];
    const uint32_t end = 1U << kEndApex[bar] | 16U << kEndApex[bar];
    if ((left.apex_mask & (start | end)) != (start | end)) continue;
    const double* p = left.apexes[kStartApex[bar]];
    const double* q = left.apexes[kStartApex[bar] + RVDNAV_BARS];
    const double* r = left.apexes[kEndApex[bar]];
    const double* s = left.apexes[kEndApex[bar] + RVDNAV_BARS];
    for (int32_t i = 0; i < kPointsPerBar; ++i) {
      const double w = (i + 0.5) / kPointsPerBar;
      rvdnav_match m = {};
      m.x = 0.5 * ((1.0 - w) * (p[0] + q[0]) + w * (r[0] + s[0]));
      m.y = 0.5 * ((1.0 - w) * (p[1] + q[1]) + w * (r[1] + s[1]));
      m.bar = bar;
      matches[n++] = m;
    }
  }
  return n;
}

}  // namespace

rvdnav_status join_views(Context& c, const GreyView* left, const GreyView* right, const rvdnav_view_result* left_view,
                         const rvdnav_view_result* right_view, bool acquire, rvdnav_frame_result* result) {
  *result = {};
  result->struct_size = sizeof(*result);
  const GreyView* images[2] = {left, right};
  const rvdnav_view_result* views[2] = {left_view, right_view};
  for (int32_t camera = 0; camera < 2; ++camera) {
    if (images[camera] == nullptr) continue;
    result->view[camera] = *views[camera];
    result->limits |= views[camera]->limits;
  }
  StageClock clock(c.config, result->stage_ns);
  if (acquire && c.has_target) acquire_from_views(c, images, result);
  clock.lap(RVDNAV_STAGE_BRACKET);
  if (left == nullptr || right == nullptr) return RVDNAV_OK;

  const rvdnav_view_result& l = result->view[0];
  const rvdnav_view_result& r = result->view[1];
  result->match_count = choose_points(l, result->matches);
  correlate_rows(c.config, c.rig, c.disparities, *left, *right, c.match, result->matches, result->match_count);
  clock.lap(RVDNAV_STAGE_EPIPOLAR);

  const RectRig rig = rect_rig(c.rig);
  const ProjectionMatrix M[2] = {projection_matrix(rig, 0), projection_matrix(rig, 1)};
  const auto locate = [&M](const double a[2], const Eigen::Vector2d& b, double p_W[3]) {
    Eigen::Vector3d p;
    if (!triangulate(M[0], M[1], {a[0], a[1]}, b, &p)) return false;
    for (int32_t i = 0; i < 3; ++i) p_W[i] = p(i);
    return true;
  };
  for (int32_t a = 0; a < RVDNAV_APEXES; ++a) {
    if ((l.apex_mask & r.apex_mask & 1U << a) == 0) continue;
    if (locate(l.apexes[a], {r.apexes[a][0], r.apexes[a][1]}, result->apexes_W[a])) result->apex_mask |= 1U << a;
  }
  for (uint32_t i = 0; i < result->match_count; ++i) {
    rvdnav_match& m = result->matches[i];
    const double xy[2] = {m.x, m.y};
    if (m.accepted != 0 && !locate(xy, {m.x - m.disparity, m.y}, m.p_W)) m.accepted = 0;
  }
  clock.lap(RVDNAV_STAGE_TRIANGULATE);
  return RVDNAV_OK;
}

}  // namespace rvdnav
