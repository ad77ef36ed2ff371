// The frame calls from outside: what they need, and that two threads give what one gives.
#include <doctest/doctest.h>

#include <cstdlib>
#include <cstring>

#include "scene.hpp"
#include "windows.hpp"

namespace {

constexpr scene::Placement kPlacement = {0.6, 0.01, 0.05, 0.1};

struct Frame {
  std::vector<uint8_t> pixels[2] = {scene::draw(0, kPlacement), scene::draw(1, kPlacement)};
  rvdnav_image left = scene::image(pixels[0]);
  rvdnav_image right = scene::image(pixels[1]);
};

const Frame& frame() {
  static const Frame drawn;
  return drawn;
}

struct Runner {
  Runner() { REQUIRE(rvdnav_runner_create(&runner) == RVDNAV_OK); }
  ~Runner() { rvdnav_runner_destroy(runner); }
  Runner(const Runner&) = delete;
  Runner& operator=(const Runner&) = delete;
  rvdnav_runner* runner = nullptr;
};

template <typename Result>
Result sized() {
  Result result = {};
  result.struct_size = sizeof(result);
  return result;
}

const rvdnav_target kTarget = scene::target();

}  // namespace

TEST_CASE("view and join check what they are given") {
  const scene::Owner owner(scene::config(), scene::rig(), &kTarget);
  REQUIRE(owner.status == RVDNAV_OK);
  auto view = sized<rvdnav_view_result>();
  auto result = sized<rvdnav_frame_result>();
  const Frame& f = frame();
  CHECK(rvdnav_view(owner.context, 0, nullptr, nullptr, 0, &view) == RVDNAV_ERROR_NULL);
  CHECK(rvdnav_view(owner.context, 2, &f.left, nullptr, 0, &view) == RVDNAV_ERROR_ARGUMENT);
  CHECK(rvdnav_view(owner.context, 0, &f.left, nullptr, 1, &view) == RVDNAV_ERROR_NULL);
  CHECK(rvdnav_view(owner.context, 0, &f.left, nullptr, 0, nullptr) == RVDNAV_ERROR_NULL);
  view.struct_size = 0;
  CHECK(rvdnav_view(owner.context, 0, &f.left, nullptr, 0, &view) == RVDNAV_ERROR_STRUCT_SIZE);
  view.struct_size = sizeof(view);
  REQUIRE(rvdnav_view(owner.context, 0, &f.left, nullptr, 0, &view) == RVDNAV_OK);
  CHECK(rvdnav_join(owner.context, &f.left, nullptr, &view, &view, 0, &result) == RVDNAV_ERROR_NULL);
  CHECK(rvdnav_join(owner.context, nullptr, nullptr, nullptr, nullptr, 0, &result) == RVDNAV_ERROR_NULL);
  CHECK(rvdnav_join(owner.context, &f.left, nullptr, &view, nullptr, 0, nullptr) == RVDNAV_ERROR_NULL);
  result.struct_size = 1;
  CHECK(rvdnav_join(owner.context, &f.left, nullptr, &view, nullptr, 0, &result) == RVDNAV_ERROR_STRUCT_SIZE);
}

TEST_CASE("nothing is acquired without a target") {
  const scene::Owner owner(scene::config(), scene::rig(), nullptr);
  REQUIRE(owner.status == RVDNAV_OK);
  const Frame& f = frame();
  auto view = sized<rvdnav_view_result>();
  auto result = sized<rvdnav_frame_result>();
  REQUIRE(rvdnav_view(owner.context, 0, &f.left, nullptr, 0, &view) == RVDNAV_OK);
  CHECK(rvdnav_join(owner.context, &f.left, nullptr, &view, nullptr, 1, &result) == RVDNAV_OK);
  CHECK(result.bracket.found == 0);
  CHECK(result.view[0].edge_count > 0);
  uint32_t count = 0;
  CHECK(rvdnav_find_bars(owner.context, 0, nullptr, 0, nullptr, 0, &count) == RVDNAV_ERROR_TARGET);
}

TEST_CASE("the runner gives what view and join give") {
  rvdnav_config config = scene::config();
  const scene::Owner one(config, scene::rig(), &kTarget);
  const scene::Owner two(config, scene::rig(), &kTarget);
  REQUIRE(one.status == RVDNAV_OK);
  const Runner runner;
  const Frame& f = frame();
  for (const bool acquire : {true, false}) {
    const std::vector<rvdnav_window> none;
    const auto left_windows = acquire ? none : scene::windows(0, kPlacement);
    const auto right_windows = acquire ? none : scene::windows(1, kPlacement);
    const auto n = static_cast<uint32_t>(left_windows.size());
    auto left = sized<rvdnav_view_result>();
    auto right = sized<rvdnav_view_result>();
    auto serial = sized<rvdnav_frame_result>();
    auto threaded = sized<rvdnav_frame_result>();
    REQUIRE(rvdnav_view(one.context, 0, &f.left, left_windows.data(), n, &left) == RVDNAV_OK);
    REQUIRE(rvdnav_view(one.context, 1, &f.right, right_windows.data(), n, &right) == RVDNAV_OK);
    REQUIRE(rvdnav_join(one.context, &f.left, &f.right, &left, &right, acquire, &serial) == RVDNAV_OK);
    REQUIRE(rvdnav_runner_process(runner.runner, two.context, &f.left, &f.right, left_windows.data(), n,
                                  right_windows.data(), n, &threaded) == RVDNAV_OK);
    // Both structures were zero before, padding included.
    CHECK(std::memcmp(&serial, &threaded, sizeof serial) == 0);
    CHECK(serial.view[0].line_mask == 0xff);
    CHECK(serial.view[1].line_mask == 0xff);
  }
}

TEST_CASE("the drawn bracket is acquired where it stands") {
  const scene::Owner owner(scene::config(), scene::rig(), &kTarget);
  const Runner runner;
  const Frame& f = frame();
  auto result = sized<rvdnav_frame_result>();
  REQUIRE(rvdnav_runner_process(runner.runner, owner.context, &f.left, &f.right, nullptr, 0, nullptr, 0, &result) ==
          RVDNAV_OK);
  REQUIRE(result.bracket.found);
  CHECK(result.bracket.p_W[0] == doctest::Approx(kPlacement.range).epsilon(0.01));
  CHECK(std::abs(result.bracket.p_W[1] - kPlacement.y) < 0.005);
  CHECK(std::abs(result.bracket.p_W[2] - kPlacement.z) < 0.005);
  CHECK(std::abs(result.bracket.R_W_C[2] - std::sin(kPlacement.angle)) < 0.05);
  CHECK(owner.guard_intact());
}

TEST_CASE("the runner works with one image and says so when there is none") {
  const scene::Owner owner(scene::config(), scene::rig(), &kTarget);
  const Runner runner;
  const Frame& f = frame();
  auto result = sized<rvdnav_frame_result>();
  const auto left = scene::windows(0, kPlacement);
  const auto right = scene::windows(1, kPlacement);
  CHECK(rvdnav_runner_process(runner.runner, owner.context, &f.left, nullptr, left.data(), 8, nullptr, 0, &result) ==
        RVDNAV_OK);
  CHECK(result.view[0].line_mask == 0xff);
  CHECK(rvdnav_runner_process(runner.runner, owner.context, nullptr, &f.right, nullptr, 0, right.data(), 8, &result) ==
        RVDNAV_OK);
  CHECK(result.view[1].line_mask == 0xff);
  CHECK(rvdnav_runner_process(runner.runner, owner.context, nullptr, nullptr, nullptr, 0, nullptr, 0, &result) ==
        RVDNAV_ERROR_NULL);
  rvdnav_image small = f.right;
  small.width = 100;
  CHECK(rvdnav_runner_process(runner.runner, owner.context, &f.left, &small, nullptr, 0, nullptr, 0, &result) ==
        RVDNAV_ERROR_IMAGE);
}

TEST_CASE("stage times come from the clock given") {
  rvdnav_config config = scene::config();
  static uint64_t ticks;
  ticks = 0;
  config.clock = [](void* user) -> uint64_t { return *static_cast<uint64_t*>(user) += 1000; };
  config.clock_user = &ticks;
  const scene::Owner owner(config, scene::rig(), &kTarget);
  auto view = sized<rvdnav_view_result>();
  REQUIRE(rvdnav_view(owner.context, 0, &frame().left, nullptr, 0, &view) == RVDNAV_OK);
  for (const int stage : {RVDNAV_STAGE_SMOOTH, RVDNAV_STAGE_EDGES, RVDNAV_STAGE_THIN, RVDNAV_STAGE_HOUGH}) {
    CHECK(view.stage_ns[stage] >= 1000);
  }
  config.clock = nullptr;
  const scene::Owner silent(config, scene::rig(), &kTarget);
  REQUIRE(rvdnav_view(silent.context, 0, &frame().left, nullptr, 0, &view) == RVDNAV_OK);
  CHECK(view.stage_ns[RVDNAV_STAGE_SMOOTH] == 0);
}

TEST_CASE("the environment chooses the instruction set") {
  int32_t isa = -1;
  unsetenv("RVDNAV_FORCE_ISA");
  CHECK(rvdnav_host_isa(&isa) == RVDNAV_OK);
  CHECK(isa == RVDNAV_ISA_AUTO);
  setenv("RVDNAV_FORCE_ISA", "scalar", 1);
  CHECK(rvdnav_host_isa(&isa) == RVDNAV_OK);
  CHECK(isa == RVDNAV_ISA_SCALAR);
  setenv("RVDNAV_FORCE_ISA", "sse2", 1);
  CHECK(rvdnav_host_isa(&isa) == RVDNAV_OK);
  CHECK(isa == RVDNAV_ISA_SSE2);
  setenv("RVDNAV_FORCE_ISA", "mmx", 1);
  CHECK(rvdnav_host_isa(&isa) == RVDNAV_ERROR_ISA);
  unsetenv("RVDNAV_FORCE_ISA");
}
