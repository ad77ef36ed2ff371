// No memory is allocated after a context and a runner are made.  This program's malloc takes the place of the system's,
// for the library and for operator new alike, and counts the calls of every thread.
#include <doctest/doctest.h>

#include <atomic>
#include <cerrno>
#include <cstddef>

#include "lent.hpp"
#include "measuring.hpp"
#include "scene.hpp"
#include "windows.hpp"

extern "C" {
void* __libc_malloc(size_t size);
void* __libc_calloc(size_t count, size_t size);
void* __libc_realloc(void* old, size_t size);
void* __libc_memalign(size_t alignment, size_t size);
}

namespace {
std::atomic<long> allocations{0};
}

extern "C" {
void* malloc(size_t size) {
  ++allocations;
  return __libc_malloc(size);
}
void* calloc(size_t count, size_t size) {
  ++allocations;
  return __libc_calloc(count, size);
}
void* realloc(void* old, size_t size) {
  ++allocations;
  return __libc_realloc(old, size);
}
void* aligned_alloc(size_t alignment, size_t size) {
  ++allocations;
  return __libc_memalign(alignment, size);
}
int posix_memalign(void** out, size_t alignment, size_t size) {
  ++allocations;
  *out = __libc_memalign(alignment, size);
  return *out == nullptr ? ENOMEM : 0;
}
}

TEST_CASE("the count sees what the library allocates") {
  const long before = allocations;
  rvdnav_runner* runner = nullptr;
  REQUIRE(rvdnav_runner_create(&runner) == RVDNAV_OK);
  CHECK(allocations > before);
  rvdnav_runner_destroy(runner);
}

TEST_CASE("200 frames allocate nothing") {
  const scene::Placement placements[] = {{1.2, 0.0, 0.04, 0.05}, {0.7, 0.02, 0.05, -0.1}, {0.4, -0.01, 0.02, 0.15}};
  constexpr size_t kPlacements = sizeof placements / sizeof *placements;
  std::vector<uint8_t> pixels[kPlacements][2];
  std::vector<rvdnav_window> windows[kPlacements][2];
  for (size_t i = 0; i < kPlacements; ++i) {
    for (int camera = 0; camera < 2; ++camera) {
      pixels[i][camera] = scene::draw(camera, placements[i]);
      windows[i][camera] = scene::windows(camera, placements[i]);
    }
  }
  const rvdnav_target target = scene::target();
  const scene::Owner owner(scene::config(), scene::rig(), &target);
  REQUIRE(owner.status == RVDNAV_OK);
  rvdnav_runner* runner = nullptr;
  REQUIRE(rvdnav_runner_create(&runner) == RVDNAV_OK);
  rvdnav_frame_result result = {};
  result.struct_size = sizeof(result);

  int failures = 0;
  int found = 0;
  int lines = 0;
  const long before = allocations;
  for (int frame = 0; frame < 200; ++frame) {
    const size_t i = static_cast<size_t>(frame) % kPlacements;
    const rvdnav_image left = scene::image(pixels[i][0]);
    const rvdnav_image right = scene::image(pixels[i][1]);
    const bool acquire = frame % 20 == 0;
    const uint32_t count = acquire ? 0 : RVDNAV_EDGES;
    failures += rvdnav_runner_process(runner, owner.context, &left, &right, windows[i][0].data(), count,
                                      windows[i][1].data(), count, &result) != RVDNAV_OK;
    found += acquire && result.bracket.found != 0;
    for (const rvdnav_line& line : result.view[0].lines) lines += line.refitted;
  }
  const long after = allocations;
  CHECK(after - before == 0);
  CHECK(failures == 0);
  CHECK(found > 0);  // the frames were worked on
  CHECK(lines > 0);
  CHECK(owner.guard_intact());
  rvdnav_runner_destroy(runner);
}

TEST_CASE("a surface in lent memory allocates nothing") {
  const scene::Placement placement = {0.7, 0.02, 0.05, -0.1};
  const std::vector<uint8_t> pixels[2] = {scene::draw(0, placement), scene::draw(1, placement)};
  const rvdnav_image left = scene::image(pixels[0]);
  const rvdnav_image right = scene::image(pixels[1]);
  const scene::Owner owner(scene::config(), scene::rig(), nullptr);
  size_t size = 0;
  REQUIRE(rvdnav_surface_size(owner.context, &size) == RVDNAV_OK);
  const Lent memory(size);
  std::vector<rvdnav_surface_point> points(10000);
  uint32_t count = 0, crossings = 0;
  const long before = allocations;
  const rvdnav_status status =
      rvdnav_surface(owner.context, &left, &right, memory.data(), size, points.data(), 10000, &count, &crossings);
  const long after = allocations;
  CHECK(after - before == 0);
  CHECK(status == RVDNAV_OK);
  CHECK(count > 0);
}

TEST_CASE("a measurement in lent memory allocates nothing") {
  const scene::Placement placement = {0.7, 0.02, 0.05, -0.1};
  const std::vector<uint8_t> pixels[2] = {scene::draw(0, placement), scene::draw(1, placement)};
  const rvdnav_image left = scene::image(pixels[0]);
  const rvdnav_image right = scene::image(pixels[1]);
  const scene::Owner owner(scene::config(), scene::rig(), nullptr);
  scene::Measuring measuring(placement);
  size_t size = 0;
  uint32_t parameters = 0;
  REQUIRE(rvdnav_measure_size(owner.context, &measuring.problem, &size, &parameters) == RVDNAV_OK);
  const Lent memory(size);
  const long before = allocations;
  const rvdnav_status status =
      rvdnav_measure(owner.context, &left, &right, &measuring.problem, memory.data(), size, &measuring.result);
  const long after = allocations;
  CHECK(after - before == 0);
  CHECK(status == RVDNAV_OK);
}
