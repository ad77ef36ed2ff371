// A drawn bracket through the whole frame: what view and join give against the exact geometry.
#include <doctest/doctest.h>

#include <algorithm>
#include <cmath>
#include <functional>
#include <vector>

#include "bracket_views.hpp"
#include "expect.hpp"
#include "lens.hpp"
#include "sample_rig.hpp"
#include "stepped_images.hpp"

using namespace rvdnav;

namespace {

const rvdnav_rig kLensRig = sample_rig();  // focal length and baseline are those of scene::rig()
const rvdnav_target kTarget = scene::target();

// Rectified coordinates of every pixel.
const std::vector<Eigen::Vector2d>& rectified(int camera) {
  static std::vector<Eigen::Vector2d> maps[2];
  std::vector<Eigen::Vector2d>& map = maps[camera];
  if (map.empty()) {
    for (int v = 0; v < kLensRig.height; ++v) {
      for (int u = 0; u < kLensRig.width; ++u) {
        double x = 0.0, y = 0.0;
        raw_to_rect(kLensRig, camera, u, v, &x, &y);
        map.emplace_back(x, y);
      }
    }
  }
  return map;
}

double speckle(double y, double z) {
  return 4.0 * (std::sin(900 * y + 310 * z) + std::sin(-420 * y + 830 * z + 1) + std::sin(1210 * y - 690 * z + 2) +
                std::sin(570 * y + 1130 * z + 3) + std::sin(-1020 * y - 250 * z + 4));
}

// Grey of what a ray meets: the speckled front face of the bracket, a panel with a lattice of bright lines, a wall.
double grey_along(const Pose& pose, const Eigen::Vector3d& centre, const Eigen::Vector3d& ray) {
  const Eigen::Vector3d origin = pose.R.transpose() * (centre - pose.p);
  const Eigen::Vector3d direction = pose.R.transpose() * ray;
  const Eigen::Vector3d hit = origin - direction * (origin.x() / direction.x());
  if (scene::inside(kTarget.outer, hit.y(), hit.z()) && !scene::inside(kTarget.inner, hit.y(), hit.z()))
    return 150.0 + speckle(hit.y(), hit.z());
  const Eigen::Vector3d wall = origin + direction * ((0.25 - origin.x()) / direction.x());
  const auto on_line = [](double t) { return std::abs(t - 0.06 * std::round(t / 0.06)) < 0.003; };
  const bool on_panel = wall.z() > 0.25 && wall.z() < 0.65 && std::abs(wall.y()) < 0.3;
  return on_panel && (on_line(wall.y()) || on_line(wall.z())) ? 75.0 : 45.0;
}

// 3x3 samples a pixel, the binomial as the lens's blur, noise.
std::vector<uint8_t> draw(int camera, const Pose& pose, plain::Random& random) {
  const int w = kLensRig.width, h = kLensRig.height;
  const std::vector<Eigen::Vector2d>& map = rectified(camera);
  const Eigen::Vector3d centre(camera == 0 ? -scene::kBaseline : 0.0, 0.0, 0.0);
  std::vector<double> sharp(map.size());
  for (size_t i = 0; i < map.size(); ++i) {
    for (int k = 0; k < 9; ++k) {
      const double x = map[i].x() + (k % 3 - 1) / 3.0, y = map[i].y() + (k / 3 - 1) / 3.0;
      sharp[i] += grey_along(pose, centre, {x / scene::kFocal, y / scene::kFocal, 1.0}) / 9.0;
    }
  }
  std::vector<uint8_t> pixels(map.size());
  for (int v = 0; v < h; ++v) {
    for (int u = 0; u < w; ++u) {
      double sum = 0.0;
      for (int dy = -1; dy <= 1; ++dy) {
        for (int dx = -1; dx <= 1; ++dx) {
          const int x = std::clamp(u + dx, 0, w - 1), y = std::clamp(v + dy, 0, h - 1);
          sum += sharp[static_cast<size_t>(y * w + x)] * (2 - std::abs(dx)) * (2 - std::abs(dy)) / 16.0;
        }
      }
      const double grey = std::round(sum + 1.5 * stepped::normal(random));
      pixels[static_cast<size_t>(v * w + u)] = static_cast<uint8_t>(std::clamp(grey, 0.0, 255.0));
    }
  }
  return pixels;
}

// A bracket wholly in both views.
Pose visible_pose(plain::Random& random, double near, double far) {
  for (;;) {
    const Pose pose = views::random_pose(random, near, far, 0.35, M_PI);
    bool inside = true;
    for (int camera = 0; camera < 2; ++camera) {
      for (const auto& corner : kTarget.outer) {
        const Eigen::Vector2d p = views::image_of(camera, pose, corner);
        inside = inside && std::abs(p.x()) < 320.0 && std::abs(p.y()) < 260.0;
      }
    }
    if (inside) return pose;
  }
}

Eigen::Vector3d world(const Pose& pose, const double p_C[3]) {
  const Eigen::Vector3d p = pose * Eigen::Vector3d(p_C[0], p_C[1], p_C[2]);
  return {p.z(), p.y(), -p.x()};
}

// How far an error of so many pixels in both views takes a point in space.
double reach(double pixels, double z) {
  return pixels * (z * z / (scene::kFocal * scene::kBaseline) + z / scene::kFocal);
}

void check_lines(const rvdnav_view_result& view, int camera, const Pose& pose) {
  CHECK(view.line_mask == 0xff);
  for (int edge = 0; edge < RVDNAV_EDGES; ++edge) {
    const rvdnav_line& line = view.lines[edge];
    CHECK(line.refitted == 1);
    const Line2 fitted = Line2::from_angle(line.rho, line.theta);
    const auto [a, b] = views::edge_image(camera, pose, edge);
    CHECK(std::abs(fitted.distance(a)) < 0.35);
    CHECK(std::abs(fitted.distance(b)) < 0.35);
    CHECK(std::abs(fitted.distance(0.5 * (a + b))) < 0.1);
  }
}

void check_points(const rvdnav_frame_result& result, const Pose& pose) {
  const double z = pose.p.z();
  CHECK(result.apex_mask == 0xff);
  for (int apex = 0; apex < RVDNAV_APEXES; ++apex) {
    const Eigen::Vector3d found(result.apexes_W[apex]);
    const Eigen::Vector3d truth = world(pose, apex < 4 ? kTarget.outer[apex] : kTarget.inner[apex - 4]);
    CHECK((found - truth).norm() < reach(0.5, z));
  }
  CHECK(result.match_count == 16);
  int accepted = 0;
  for (uint32_t i = 0; i < result.match_count; ++i) {
    const rvdnav_match& m = result.matches[i];
    if (m.accepted == 0) continue;
    ++accepted;
    // On the front face, in the middle of its bar.
    const Eigen::Vector3d p_R(-m.p_W[2], m.p_W[1], m.p_W[0]);
    const Eigen::Vector3d p_C = pose.R.transpose() * (p_R - pose.p);
    CHECK(std::abs(p_C.x()) < reach(1.0, z));
  }
  CHECK(accepted >= 4);
}

template <typename Result>
Result sized() {
  Result result = {};
  result.struct_size = sizeof(result);
  return result;
}

struct Frame {
  explicit Frame(const Pose& pose, plain::Random& random)
      : pixels{draw(0, pose, random), draw(1, pose, random)},
        images{{pixels[0].data(), kLensRig.width, kLensRig.height, kLensRig.width},
               {pixels[1].data(), kLensRig.width, kLensRig.height, kLensRig.width}} {}

  rvdnav_frame_result process(const scene::Owner& owner, const std::vector<rvdnav_window> (&windows)[2]) const {
    rvdnav_view_result seen[2] = {sized<rvdnav_view_result>(), sized<rvdnav_view_result>()};
    for (int camera = 0; camera < 2; ++camera) {
      REQUIRE(rvdnav_view(owner.context, camera, &images[camera], windows[camera].data(),
                          static_cast<uint32_t>(windows[camera].size()), &seen[camera]) == RVDNAV_OK);
    }
    auto result = sized<rvdnav_frame_result>();
    REQUIRE(rvdnav_join(owner.context, &images[0], &images[1], &seen[0], &seen[1], windows[0].empty() ? 1 : 0,
                        &result) == RVDNAV_OK);
    return result;
  }

  std::vector<uint8_t> pixels[2];
  rvdnav_image images[2];
};

}  // namespace

TEST_CASE("a frame gives the bracket, its lines and its points, first without and then with windows") {
  plain::Random random(120);
  const BracketModel model = make_bracket_model(kTarget);
  const scene::Owner owner(scene::config(), kLensRig, &kTarget);
  REQUIRE(owner.status == RVDNAV_OK);
  int found = 0;
  for (int i = 0; i < plain::scenes(4); ++i) {
    const Pose truth = visible_pose(random, 0.42, 0.9);
    const Frame frame(truth, random);
    const std::vector<rvdnav_window> none[2];
    const rvdnav_frame_result acquired = frame.process(owner, none);
    if (acquired.bracket.found != 0) {
      ++found;
      const Pose pose = views::pose_of(acquired.bracket);
      CHECK(views::shift_of(pose, truth) < 0.01);
      CHECK(views::turn_of(pose, truth) < 0.05);
      for (int camera = 0; camera < 2; ++camera) check_lines(acquired.view[camera], camera, truth);
      check_points(acquired, truth);
    }
    // Windows from where the bracket was a little before.
    Pose before = truth;
    before.p += Eigen::Vector3d(0.001, -0.001, 0.003);
    std::vector<rvdnav_window> windows[2];
    for (int camera = 0; camera < 2; ++camera) {
      rvdnav_window expected[RVDNAV_EDGES];
      const uint32_t n = expect_edges(views::rig(), model, camera, before, 4.0, 0.04, expected);
      windows[camera].assign(expected, expected + n);
    }
    const rvdnav_frame_result tracked = frame.process(owner, windows);
    CHECK(tracked.bracket.found == 0);
    CHECK(tracked.bracket.hypotheses == 0);
    for (int camera = 0; camera < 2; ++camera) check_lines(tracked.view[camera], camera, truth);
    check_points(tracked, truth);
  }
  CHECK(found == plain::scenes(4));
  CHECK(owner.guard_intact());
}

TEST_CASE("edges that are covered are reported lost, and so are their apexes") {
  plain::Random random(121);
  const BracketModel model = make_bracket_model(kTarget);
  const scene::Owner owner(scene::config(), kLensRig, &kTarget);
  const Pose truth = visible_pose(random, 0.6, 0.7);
  Frame frame(truth, random);
  // Everything about the corner P3 in the left view disappears behind something grey.
  const double* corners[] = {kTarget.outer[1], kTarget.outer[2], kTarget.inner[1], kTarget.inner[2]};
  for (size_t i = 0; i < frame.pixels[0].size(); ++i) {
    const Eigen::Vector2d p = rectified(0)[i];
    for (const double* corner : {corners[0], corners[1], corners[2], corners[3]}) {
      const Eigen::Vector2d start = views::image_of(0, truth, corner);
      if ((p - start).norm() < 60.0) frame.pixels[0][i] = 90;
    }
  }
  std::vector<rvdnav_window> windows[2];
  for (int camera = 0; camera < 2; ++camera) {
    rvdnav_window expected[RVDNAV_EDGES];
    const uint32_t n = expect_edges(views::rig(), model, camera, truth, 3.0, 0.03, expected);
    windows[camera].assign(expected, expected + n);
  }
  const rvdnav_frame_result result = frame.process(owner, windows);
  constexpr uint32_t kL3 = 3U << 4;  // both edges of the bar from P2 to P3
  CHECK((result.view[0].line_mask & kL3) == 0);
  CHECK((result.view[1].line_mask & kL3) == kL3);
  constexpr uint32_t kOnL3 = 1U << 1 | 1U << 2 | 1U << 5 | 1U << 6;
  CHECK((result.view[0].apex_mask & kOnL3) == 0);
  CHECK((result.apex_mask & kOnL3) == 0);
  for (int apex = 0; apex < RVDNAV_APEXES; ++apex) {
    if ((result.apex_mask >> apex & 1U) == 0) CHECK(result.apexes_W[apex][0] == 0.0);
  }
  for (uint32_t i = 0; i < result.match_count; ++i) CHECK(result.matches[i].bar == 3);
}
