#include <doctest/doctest.h>

#include <cmath>
#include <vector>

#include "bars.hpp"
#include "bracket.hpp"
#include "bracket_views.hpp"
#include "expect.hpp"

using namespace rvdnav;
using views::pose_of;
using views::random_pose;
using views::shift_of;
using views::turn_of;
using views::View;

namespace {

const BracketModel kModel = make_bracket_model(scene::target());
constexpr RangeGate kGate = {0.25, 1.7};

rvdnav_bracket acquire(const View (&scene_views)[2], bool with_left = true, bool with_right = true,
                       const BracketModel& model = kModel) {
  const bool present[2] = {with_left, with_right};
  ViewSegments faces[2] = {};
  std::vector<Proposal> proposals;
  for (int camera = 0; camera < 2; ++camera) {
    if (!present[camera]) continue;
    const View& view = scene_views[camera];
    faces[camera] = view.face();
    std::vector<rvdnav_bar> bars(256);
    uint32_t total = 0;
    const uint32_t count = find_bars(view.segments.data(), static_cast<uint32_t>(view.segments.size()),
                                     {2.2, 45.0, 40.0}, bars.data(), 256, &total);
    Proposal found[32];
    bool limited = false;
    const uint32_t n = propose_brackets(views::rig(), model, camera, {faces[camera], bars.data(), count}, kGate, 20000,
                                        found, 32, &limited);
    proposals.insert(proposals.end(), found, found + n);
  }
  Eigen::Vector2d right_shift;
  bool loose = false;
  return acquire_bracket(views::rig(), model, faces, present, kGate, proposals.data(),
                         static_cast<uint32_t>(proposals.size()), &right_shift, &loose);
}

}  // namespace

TEST_CASE("the model knows its edges and bars") {
  const rvdnav_target t = scene::target();
  for (int bar = 0; bar < 4; ++bar) {
    for (int k = 0; k < 3; ++k) {
      CHECK(kModel.edge[2 * bar].a(k) == t.outer[views::kCorner[bar][0]][k]);
      CHECK(kModel.edge[2 * bar].b(k) == t.outer[views::kCorner[bar][1]][k]);
      CHECK(kModel.edge[2 * bar + 1].a(k) == t.inner[views::kCorner[bar][0]][k]);
      CHECK(kModel.edge[2 * bar + 1].b(k) == t.inner[views::kCorner[bar][1]][k]);
    }
    CHECK(kModel.bar_width[bar] == doctest::Approx(0.014).epsilon(1e-4));
    // Around the frame the end of a bar is the start of the next one.
    CHECK(kEndApex[bar] == kStartApex[kNextBar[bar]]);
    CHECK(kPreviousBar[kNextBar[bar]] == bar);
    CHECK((kModel.axis_end[bar] - kModel.axis_start[kNextBar[bar]]).norm() < 1e-12);
  }
}

TEST_CASE("edges are expected where they are seen") {
  plain::Random random(60);
  for (int i = 0; i < 50; ++i) {
    const Pose pose = random_pose(random, 0.4, 1.5, 0.6, M_PI);
    for (int camera = 0; camera < 2; ++camera) {
      rvdnav_window windows[RVDNAV_EDGES];
      REQUIRE(expect_edges(views::rig(), kModel, camera, pose, 2.5, 0.03, windows) == RVDNAV_EDGES);
      for (int edge = 0; edge < RVDNAV_EDGES; ++edge) {
        const auto [a, b] = views::edge_image(camera, pose, edge);
        const rvdnav_segment s = views::segment_between(a, b, a);
        CHECK(windows[edge].edge == edge);
        CHECK(windows[edge].rho == doctest::Approx(s.rho));
        CHECK(windows[edge].theta == doctest::Approx(s.theta));
        CHECK(windows[edge].t_min == doctest::Approx(s.t_min));
        CHECK(windows[edge].t_max == doctest::Approx(s.t_max));
        CHECK(windows[edge].half_rho == 2.5);
        CHECK(windows[edge].half_theta == 0.03);
      }
    }
  }
}

TEST_CASE("edges that reach behind the camera are not expected") {
  rvdnav_window windows[RVDNAV_EDGES];
  Pose pose = {Eigen::Matrix3d::Identity(), {0.0, 0.0, 0.0}};
  pose.R << 0, 0, -1, 0, 1, 0, 1, 0, 0;
  pose.p.z() = 0.019;
  CHECK(expect_edges(views::rig(), kModel, 1, pose, 2.0, 0.03, windows) == 0);
  // Looked at along its plane, with only l2 in front: l2 alone can be seen whole.
  pose.R << 1, 0, 0, 0, 1, 0, 0, 0, 1;
  pose.p.z() = -0.09;
  const uint32_t n = expect_edges(views::rig(), kModel, 1, pose, 2.0, 0.03, windows);
  REQUIRE(n == 2);
  CHECK(windows[0].edge == 2);
  CHECK(windows[1].edge == 3);
}

TEST_CASE("the pose is pulled onto exact lines") {
  plain::Random random(61);
  for (int i = 0; i < 60; ++i) {
    const Pose truth = random_pose(random, 0.4, 1.5, 0.7, M_PI);
    std::vector<LineMatch> matches;
    for (int camera = 0; camera < (i % 3 == 0 ? 1 : 2); ++camera) {
      for (int edge = 0; edge < RVDNAV_EDGES; ++edge) {
        const auto [a, b] = views::edge_image(camera, truth, edge);
        const rvdnav_segment s = views::segment_between(a, b, a);
        matches.push_back(
            {camera, edge, 1, Line2::from_angle(s.rho, s.theta), 1.0, kModel.edge[edge].a, kModel.edge[edge].b});
      }
    }
    const Eigen::Vector3d turn(random.real(-0.1, 0.1), random.real(-0.1, 0.1), random.real(-0.1, 0.1));
    const Eigen::Vector3d shift(random.real(-0.02, 0.02), random.real(-0.02, 0.02), random.real(-0.04, 0.04));
    Pose pose = {Eigen::AngleAxisd(turn.norm(), turn.normalized()) * truth.R, truth.p + shift};
    double rms = 1.0;
    REQUIRE(
        fit_pose_to_lines(views::rig(), matches.data(), static_cast<uint32_t>(matches.size()), 30, 50.0, &pose, &rms));
    CHECK(rms < 1e-3);
    CHECK(shift_of(pose, truth) < 1e-4);
    CHECK(turn_of(pose, truth) < 1e-3);
    CHECK((pose.R.transpose() * pose.R - Eigen::Matrix3d::Identity()).norm() < 1e-12);

    Pose behind = {truth.R, {0.0, 0.0, -1.0}};
    CHECK_FALSE(fit_pose_to_lines(views::rig(), matches.data(), static_cast<uint32_t>(matches.size()), 30, 50.0,
                                  &behind, &rms));
  }
}

TEST_CASE("the rms of a fit is the weighted one, and a hopeless fit ends early") {
  const Pose truth = {(Eigen::Matrix3d() << 0, 0, -1, 0, 1, 0, 1, 0, 0).finished(), {-0.06, 0.0, 0.8}};
  std::vector<LineMatch> matches;
  for (int edge = 0; edge < RVDNAV_EDGES; ++edge) {
    const auto [a, b] = views::edge_image(0, truth, edge);
    const rvdnav_segment s = views::segment_between(a, b, a);
    matches.push_back(
        {0, edge, 1, Line2::from_angle(s.rho, s.theta), 1.0 + edge, kModel.edge[edge].a, kModel.edge[edge].b});
  }
  // Where the fit may not move, the residual is that of the start: half a pixel across the first line alone.
  matches[0].line.rho += 0.5;
  Pose pose = truth;
  double rms = 0.0;
  REQUIRE(fit_pose_to_lines(views::rig(), matches.data(), 8, 0, 50.0, &pose, &rms));
  CHECK(rms == doctest::Approx(0.5 * std::sqrt(1.0 / 36.0)));
  for (size_t i = 0; i < 8; ++i) matches[i].line.rho += i % 2 == 0 ? 60.0 : -60.0;
  pose = truth;
  CHECK_FALSE(fit_pose_to_lines(views::rig(), matches.data(), 8, 30, 6.0, &pose, &rms));
}

TEST_CASE("segments support a pose by what they cover of its edges") {
  plain::Random random(62);
  const Pose pose = random_pose(random, 0.7, 0.8, 0.3, 0.5);
  View view;
  views::add_bracket(view, 0, pose, random, 0.0);
  const Tolerance tolerance = {2.0, 0.06};
  EdgeSupport s = edge_support(views::rig(), kModel, 0, view.face(), pose, tolerance);
  for (int edge = 0; edge < RVDNAV_EDGES; ++edge) {
    const auto [a, b] = views::edge_image(0, pose, edge);
    CHECK(s.length[edge] == doctest::Approx((b - a).norm()).epsilon(0.02));  // or that of the back edge
    CHECK(std::max(s.covered[edge][0], s.covered[edge][1]) == doctest::Approx(1.0));
    CHECK(std::min(s.covered[edge][0], s.covered[edge][1]) == 0.0);
    // Outer edges have the bar, and so the bright side, on the inside of the frame; inner ones outside of theirs.
    CHECK(s.covered[edge][edge % 2 == 0 ? 1 : 0] == doctest::Approx(1.0));
  }
  CHECK(combine(&s, 1).fraction == doctest::Approx(1.0));

  // Half of one segment gone: half of its edge is covered.
  const double middle = 0.5 * (view.segments[0].t_min + view.segments[0].t_max);
  view.segments[0].t_max = middle;
  s = edge_support(views::rig(), kModel, 0, view.face(), pose, tolerance);
  CHECK(s.covered[0][1] == doctest::Approx(0.5));
  // Displaced by half of the tolerance it counts three quarters, beyond the tolerance nothing.
  view.lines[1].rho += 1.0;
  view.segments[1].rho += 1.0;
  view.lines[2].rho += 2.1;
  view.segments[2].rho += 2.1;
  s = edge_support(views::rig(), kModel, 0, view.face(), pose, tolerance);
  CHECK(s.covered[1][0] == doctest::Approx(0.75));
  CHECK(s.covered[2][1] == 0.0);
}

TEST_CASE("views that disagree about the bright side do not add up") {
  EdgeSupport both[2] = {};
  for (int edge = 0; edge < RVDNAV_EDGES; ++edge) {
    both[0].length[edge] = 100.0;
    both[1].length[edge] = 300.0;
    both[0].covered[edge][0] = 1.0;
    both[1].covered[edge][edge < 4 ? 0 : 1] = 1.0;
  }
  const CombinedSupport combined = combine(both, 2);
  CHECK(combined.fraction == doctest::Approx((4 * 400.0 + 4 * 300.0) / (8 * 400.0)));
  CHECK(combined.covered[0] == doctest::Approx(1.0));
  CHECK(combined.covered[5] == doctest::Approx(0.5));
}

TEST_CASE("every edge is matched with the segment that lies on it best") {
  plain::Random random(63);
  const Pose pose = random_pose(random, 0.7, 0.8, 0.3, 0.5);
  View view;
  // A worse one beside each right one.
  views::add_bracket(view, 1, pose, random, 0.0);
  for (size_t i = 0; i < 8; ++i) {
    rvdnav_segment s = view.segments[i];
    s.rho += 1.2;
    view.add(s);
  }
  LineMatch matches[RVDNAV_EDGES];
  REQUIRE(match_edges(views::rig(), kModel, 1, view.face(), pose, {2.0, 0.06}, matches) == RVDNAV_EDGES);
  for (int edge = 0; edge < RVDNAV_EDGES; ++edge) {
    CHECK(matches[edge].camera == 1);
    CHECK(matches[edge].edge == edge);
    CHECK(matches[edge].line.rho == view.segments[static_cast<size_t>(edge)].rho);
    CHECK((matches[edge].from - kModel.edge[edge].a).norm() < 1e-9);
    CHECK((matches[edge].to - kModel.edge[edge].b).norm() < 1e-9);
  }
}

TEST_CASE("the bracket is acquired among distractors, or nothing is, but never another pose") {
  plain::Random random(64);
  int found = 0;
  constexpr int kScenes = plain::scenes(60);
  for (int i = 0; i < kScenes; ++i) {
    const Pose truth = random_pose(random, 0.45, 1.5, 0.5, M_PI);
    View both[2];
    for (int camera = 0; camera < 2; ++camera) {
      views::add_distractors(both[camera], random, 40);
      views::add_bracket(both[camera], camera, truth, random, 0.3);
    }
    const rvdnav_bracket bracket = acquire(both);
    if (bracket.found == 0) continue;
    ++found;
    CHECK(bracket.score > 0.8);
    CHECK(bracket.runner_up < bracket.score);
    const Pose pose = pose_of(bracket);
    CHECK(shift_of(pose, truth) < 0.01);
    CHECK(turn_of(pose, truth) < 0.08);  // what the displaced ends can do to the tilt at the far end
  }
  CHECK(found >= kScenes - 2);
}

TEST_CASE("one view proposes the true pose") {
  plain::Random random(72);
  int missed = 0;
  for (int i = 0; i < plain::scenes(40); ++i) {
    const Pose truth = random_pose(random, 0.5, 0.9, 0.6, M_PI);
    View view;
    views::add_bracket(view, i % 2, truth, random, 0.0);
    std::vector<rvdnav_bar> bars(256);
    uint32_t total = 0;
    const uint32_t count = find_bars(view.segments.data(), static_cast<uint32_t>(view.segments.size()),
                                     {2.2, 45.0, 40.0}, bars.data(), 256, &total);
    Proposal proposals[32];
    bool limited = false;
    const uint32_t n = propose_brackets(views::rig(), kModel, i % 2, {view.face(), bars.data(), count}, kGate, 20000,
                                        proposals, 32, &limited);
    double least = 1.0;
    for (uint32_t k = 0; k < n; ++k) least = std::min(least, turn_of(proposals[k].pose, truth));
    missed += least < 0.05 ? 0 : 1;
  }
  CHECK(missed <= 1);  // a fit may end in the mirror image about the line of sight
}

TEST_CASE("three bars are enough, two are not") {
  plain::Random random(65);
  for (int i = 0; i < 24; ++i) {
    const Pose truth = random_pose(random, 0.45, 1.2, 0.4, M_PI);
    const uint32_t missing = 1U << (i % 4);
    View three[2], two[2];
    for (int camera = 0; camera < 2; ++camera) {
      views::add_bracket(three[camera], camera, truth, random, 0.2, missing);
      views::add_bracket(two[camera], camera, truth, random, 0.2, missing | 1U << ((i + 1) % 4));
    }
    const rvdnav_bracket bracket = acquire(three);
    REQUIRE(bracket.found == 1);
    CHECK(shift_of(pose_of(bracket), truth) < 0.01);
    CHECK(turn_of(pose_of(bracket), truth) < 0.03);
    CHECK(acquire(two).found == 0);
  }
}

TEST_CASE("distractors alone are no bracket") {
  plain::Random random(66);
  for (int i = 0; i < 20; ++i) {
    View both[2];
    for (View& view : both) views::add_distractors(view, random, 60);
    CHECK(acquire(both).found == 0);
  }
}

TEST_CASE("of two brackets none is chosen") {
  plain::Random random(67);
  for (int i = 0; i < 10; ++i) {
    const Pose one = random_pose(random, 0.9, 1.2, 0.2, 0.3);
    Pose other = one;
    other.p.x() += 0.3;
    View both[2];
    for (int camera = 0; camera < 2; ++camera) {
      views::add_bracket(both[camera], camera, one, random, 0.1);
      views::add_bracket(both[camera], camera, other, random, 0.1);
    }
    const rvdnav_bracket bracket = acquire(both);
    CHECK(bracket.found == 0);
    CHECK(bracket.ambiguous == 1);
    CHECK(bracket.runner_up > 0.9 * bracket.score);
  }
}

TEST_CASE("views that do not belong together give nothing") {
  plain::Random random(68);
  for (int i = 0; i < 20; ++i) {
    const Pose left = random_pose(random, 0.5, 1.2, 0.3, M_PI);
    Pose right = left;
    right.R = Eigen::AngleAxisd(0.25, Eigen::Vector3d::UnitZ()) * right.R;
    View both[2];
    views::add_bracket(both[0], 0, left, random, 0.1);
    views::add_bracket(both[1], 1, right, random, 0.1);
    CHECK(acquire(both).found == 0);
  }
}

TEST_CASE("a target outside the range gate is not acquired") {
  plain::Random random(69);
  for (const double z : {0.2, 1.85}) {
    const Pose truth = random_pose(random, z, z + 0.01, 0.1, 0.1);
    View both[2];
    for (int camera = 0; camera < 2; ++camera) views::add_bracket(both[camera], camera, truth, random, 0.05);
    CHECK(acquire(both).found == 0);
  }
}

TEST_CASE("one view gives the pose, says that it cannot tell, or nothing") {
  plain::Random random(70);
  int found = 0;
  for (int i = 0; i < 40; ++i) {
    const Pose truth = random_pose(random, 0.4, 0.9, 0.5, M_PI);
    View both[2];
    const int camera = i % 2;
    views::add_bracket(both[camera], camera, truth, random, 0.1);
    const rvdnav_bracket bracket = acquire(both, camera == 0, camera == 1);
    if (bracket.found == 0) continue;
    ++found;
    CHECK(shift_of(pose_of(bracket), truth) < 0.03);
    CHECK(turn_of(pose_of(bracket), truth) < 0.1);
  }
  CHECK(found > 10);
}

TEST_CASE("work limits are kept and told") {
  plain::Random random(71);
  View view;
  views::add_distractors(view, random, 60);
  views::add_bracket(view, 0, random_pose(random, 0.5, 0.6, 0.3, 0.3), random, 0.1);
  std::vector<rvdnav_bar> bars(256);
  uint32_t total = 0;
  const uint32_t count = find_bars(view.segments.data(), static_cast<uint32_t>(view.segments.size()), {2.2, 45.0, 40.0},
                                   bars.data(), 256, &total);
  const ViewBars with_bars = {view.face(), bars.data(), count};
  Proposal proposals[32];
  bool limited = false;
  const uint32_t all = propose_brackets(views::rig(), kModel, 0, with_bars, kGate, 20000, proposals, 32, &limited);
  CHECK(all >= 1);
  CHECK(all < 32);
  CHECK_FALSE(limited);
  for (uint32_t i = 1; i < all; ++i) CHECK(proposals[i - 1].support >= proposals[i].support);
  CHECK(propose_brackets(views::rig(), kModel, 0, with_bars, kGate, 20000, proposals, 1, &limited) == 1);
  CHECK(limited == (all > 1));
  CHECK(propose_brackets(views::rig(), kModel, 0, with_bars, kGate, 1, proposals, 32, &limited) <= 2);
  CHECK(limited);
}

TEST_CASE("a bracket a millimetre off before a right view some pixels off is acquired loosely") {
  plain::Random random(73);
  int found = 0;
  constexpr int kScenes = plain::scenes(40);
  for (int i = 0; i < kScenes; ++i) {
    const Pose truth = random_pose(random, 0.5, 1.2, 0.4, M_PI);
    rvdnav_target told = scene::target();
    for (int corner = 0; corner < 4; ++corner) {
      for (int k = 1; k < 3; ++k) {
        told.outer[corner][k] += random.between(0, 1) == 0 ? 1e-3 : -1e-3;
        told.inner[corner][k] += random.between(0, 1) == 0 ? 1e-3 : -1e-3;
      }
    }
    View both[2];
    for (int camera = 0; camera < 2; ++camera) {
      views::add_distractors(both[camera], random, 20);
      views::add_bracket(both[camera], camera, truth, random, 0.2);
    }
    views::shift(both[1], {6.0, -5.0});
    const rvdnav_bracket bracket = acquire(both, true, true, make_bracket_model(told));
    if (bracket.found == 0) continue;
    ++found;
    const Pose pose = pose_of(bracket);
    CHECK(shift_of(pose, truth) < 0.1);  // the shift changes the disparity, and with it the range
    CHECK(turn_of(pose, truth) < 0.25);
  }
  CHECK(found >= 3 * kScenes / 4);
}

TEST_CASE("nothing is acquired loosely where nothing is") {
  plain::Random random(74);
  for (int i = 0; i < plain::scenes(20); ++i) {
    View both[2];
    for (View& view : both) views::add_distractors(view, random, 80);
    views::shift(both[1], {6.0, -5.0});
    CHECK(acquire(both).found == 0);
  }
}
