// What the ABI accepts and refuses.
#include <doctest/doctest.h>

#include <array>
#include <cstring>
#include <limits>

#include "scene.hpp"

namespace {

constexpr double kNan = std::numeric_limits<double>::quiet_NaN();

rvdnav_status status_of(const rvdnav_config& config, const rvdnav_rig& rig, const rvdnav_target* target) {
  return scene::Owner(config, rig, target).status;
}

template <typename Change>
rvdnav_status with_rig(Change change) {
  rvdnav_rig rig = scene::rig();
  change(rig);
  return status_of(scene::config(), rig, nullptr);
}

template <typename Change>
rvdnav_status with_target(Change change) {
  rvdnav_target target = scene::target();
  change(target);
  return status_of(scene::config(), scene::rig(), &target);
}

template <typename Change>
rvdnav_status with_config(Change change) {
  rvdnav_config config = scene::config();
  change(config);
  return status_of(config, scene::rig(), nullptr);
}

}  // namespace

TEST_CASE("the library names itself, its statuses and its structures") {
  CHECK(rvdnav_abi_version() == RVDNAV_ABI_VERSION);
  for (rvdnav_status status = 0; status >= RVDNAV_ERROR_THREAD; --status) {
    CHECK(std::strcmp(rvdnav_status_text(status), "unknown status") != 0);
  }
  CHECK(std::strcmp(rvdnav_status_text(1), "unknown status") == 0);
  CHECK(rvdnav_struct_size("rvdnav_rig") == sizeof(rvdnav_rig));
  CHECK(rvdnav_struct_size("rvdnav_frame_result") == sizeof(rvdnav_frame_result));
  CHECK(rvdnav_struct_size("rvdnav_nothing") == 0);
  CHECK(rvdnav_struct_size(nullptr) == 0);
}

TEST_CASE("a context is made from good parts, with and without a target, for one camera and two") {
  const rvdnav_target target = scene::target();
  CHECK(status_of(scene::config(), scene::rig(), &target) == RVDNAV_OK);
  CHECK(status_of(scene::config(), scene::rig(), nullptr) == RVDNAV_OK);
  CHECK(status_of(scene::config(), scene::rig(1), &target) == RVDNAV_OK);
}

TEST_CASE("a context needs its memory, aligned") {
  const rvdnav_config config = scene::config();
  const rvdnav_rig rig = scene::rig();
  size_t size = 0;
  REQUIRE(rvdnav_context_size(&config, &rig, &size) == RVDNAV_OK);
  const std::unique_ptr<void, scene::Owner::Free> memory(std::aligned_alloc(64, (size / 64 + 2) * 64));
  rvdnav_context* context = nullptr;
  CHECK(rvdnav_context_init(memory.get(), size, &config, &rig, nullptr, &context) == RVDNAV_OK);
  CHECK(context == memory.get());
  CHECK(rvdnav_context_init(memory.get(), size - 1, &config, &rig, nullptr, &context) == RVDNAV_ERROR_MEMORY);
  CHECK(context == nullptr);
  auto* odd = static_cast<uint8_t*>(memory.get()) + 8;
  CHECK(rvdnav_context_init(odd, size, &config, &rig, nullptr, &context) == RVDNAV_ERROR_MEMORY);
  CHECK(rvdnav_context_init(nullptr, size, &config, &rig, nullptr, &context) == RVDNAV_ERROR_NULL);
  CHECK(rvdnav_context_init(memory.get(), size, nullptr, &rig, nullptr, &context) == RVDNAV_ERROR_NULL);
  CHECK(rvdnav_context_size(&config, nullptr, &size) == RVDNAV_ERROR_NULL);
}

TEST_CASE("a context for one camera needs less memory than for two") {
  const rvdnav_config config = scene::config();
  const rvdnav_rig one = scene::rig(1);
  const rvdnav_rig two = scene::rig(2);
  size_t size_one = 0;
  size_t size_two = 0;
  REQUIRE(rvdnav_context_size(&config, &one, &size_one) == RVDNAV_OK);
  REQUIRE(rvdnav_context_size(&config, &two, &size_two) == RVDNAV_OK);
  CHECK(size_one < size_two);
}

TEST_CASE("an unusable rig is refused") {
  CHECK(with_rig([](rvdnav_rig& r) { r.struct_size = 8; }) == RVDNAV_ERROR_STRUCT_SIZE);
  CHECK(with_rig([](rvdnav_rig& r) { r.width = 4097; }) == RVDNAV_ERROR_CALIBRATION);
  CHECK(with_rig([](rvdnav_rig& r) { r.height = 0; }) == RVDNAV_ERROR_CALIBRATION);
  CHECK(with_rig([](rvdnav_rig& r) { r.camera_count = 3; }) == RVDNAV_ERROR_CALIBRATION);
  CHECK(with_rig([](rvdnav_rig& r) { r.focal_rect = 0.0; }) == RVDNAV_ERROR_CALIBRATION);
  CHECK(with_rig([](rvdnav_rig& r) { r.baseline = 0.0; }) == RVDNAV_ERROR_CALIBRATION);
  CHECK(with_rig([](rvdnav_rig& r) { r.baseline = kNan; }) == RVDNAV_ERROR_CALIBRATION);
  CHECK(with_rig([](rvdnav_rig& r) { r.camera[1].fx = -1.0; }) == RVDNAV_ERROR_CALIBRATION);
  CHECK(with_rig([](rvdnav_rig& r) { r.camera[0].p2 = kNan; }) == RVDNAV_ERROR_CALIBRATION);
  CHECK(with_rig([](rvdnav_rig& r) { r.camera[0].R_rect_cam[0] = -1.0; }) == RVDNAV_ERROR_CALIBRATION);
  CHECK(with_rig([](rvdnav_rig& r) { r.camera[1].R_rect_cam[1] = 1e-5; }) == RVDNAV_ERROR_CALIBRATION);
  CHECK(with_rig([](rvdnav_rig& r) { r.camera[0].cx = 9000.0; }) == RVDNAV_ERROR_CALIBRATION);  // beyond the map
}

TEST_CASE("a degenerate bracket is refused") {
  CHECK(with_target([](rvdnav_target& t) { t.struct_size = 0; }) == RVDNAV_ERROR_STRUCT_SIZE);
  CHECK(with_target([](rvdnav_target& t) { t.thickness = -0.001; }) == RVDNAV_ERROR_TARGET);
  CHECK(with_target([](rvdnav_target& t) { t.outer[2][1] = kNan; }) == RVDNAV_ERROR_TARGET);
  CHECK(with_target([](rvdnav_target& t) { std::memcpy(t.outer[1], t.outer[0], sizeof t.outer[0]); }) ==
        RVDNAV_ERROR_TARGET);
  CHECK(with_target([](rvdnav_target& t) {  // all on l1
          for (auto& p : t.outer) p[2] = 0.0;
        }) == RVDNAV_ERROR_TARGET);
  CHECK(with_target([](rvdnav_target& t) { t.outer[3][0] = 0.02; }) == RVDNAV_ERROR_TARGET);  // off the plane
  CHECK(with_target([](rvdnav_target& t) {                                                    // bars without width
          std::memcpy(t.inner, t.outer, sizeof t.outer);
        }) == RVDNAV_ERROR_TARGET);
}

TEST_CASE("settings out of their range are refused") {
  CHECK(with_config([](rvdnav_config& c) { c.struct_size -= 4; }) == RVDNAV_ERROR_STRUCT_SIZE);
  CHECK(with_config([](rvdnav_config& c) { c.edge_floor = 0; }) == RVDNAV_ERROR_ARGUMENT);
  CHECK(with_config([](rvdnav_config& c) { c.hough_rho_bins = 40000; }) == RVDNAV_ERROR_ARGUMENT);
  CHECK(with_config([](rvdnav_config& c) { c.max_edgels = -1; }) == RVDNAV_ERROR_ARGUMENT);
  CHECK(with_config([](rvdnav_config& c) { c.range_max = c.range_min; }) == RVDNAV_ERROR_ARGUMENT);
  CHECK(with_config([](rvdnav_config& c) { c.blur_sigma = kNan; }) == RVDNAV_ERROR_ARGUMENT);
  CHECK(with_config([](rvdnav_config& c) { c.isa = 9; }) == RVDNAV_ERROR_ARGUMENT);
#if defined(__x86_64__)
  CHECK(with_config([](rvdnav_config& c) { c.isa = RVDNAV_ISA_NEON; }) == RVDNAV_ERROR_ISA);
#endif
}

TEST_CASE("what isn't a context is refused") {
  const scene::Owner owner(scene::config(RVDNAV_ISA_SCALAR), scene::rig(), nullptr);
  REQUIRE(owner.status == RVDNAV_OK);
  CHECK(rvdnav_context_isa(owner.context) == RVDNAV_ISA_SCALAR);
  CHECK(rvdnav_context_isa(nullptr) == RVDNAV_ERROR_NULL);
  const std::unique_ptr<void, scene::Owner::Free> copy(std::aligned_alloc(64, (owner.size / 64 + 1) * 64));
  std::memset(copy.get(), 0, owner.size);
  CHECK(rvdnav_context_isa(static_cast<rvdnav_context*>(copy.get())) == RVDNAV_ERROR_CONTEXT);
  std::memcpy(copy.get(), owner.memory.get(), owner.size);  // its arrays are still those of the original
  CHECK(rvdnav_context_isa(static_cast<rvdnav_context*>(copy.get())) == RVDNAV_ERROR_CONTEXT);
}

TEST_CASE("images and cameras are checked") {
  const scene::Owner owner(scene::config(), scene::rig(1), nullptr);
  REQUIRE(owner.status == RVDNAV_OK);
  const std::vector<uint8_t> pixels(static_cast<size_t>(scene::kWidth) * scene::kHeight, 80);
  std::vector<uint8_t> smoothed(pixels.size());
  rvdnav_image image = scene::image(pixels);
  CHECK(rvdnav_smooth(owner.context, 0, &image, smoothed.data()) == RVDNAV_OK);
  CHECK(rvdnav_smooth(owner.context, 1, &image, smoothed.data()) == RVDNAV_ERROR_ARGUMENT);
  CHECK(rvdnav_smooth(owner.context, -1, &image, smoothed.data()) == RVDNAV_ERROR_ARGUMENT);
  CHECK(rvdnav_smooth(owner.context, 0, nullptr, smoothed.data()) == RVDNAV_ERROR_NULL);
  CHECK(rvdnav_smooth(owner.context, 0, &image, nullptr) == RVDNAV_ERROR_NULL);
  image.stride = scene::kWidth - 1;
  CHECK(rvdnav_smooth(owner.context, 0, &image, smoothed.data()) == RVDNAV_ERROR_IMAGE);
  image = scene::image(pixels);
  image.height -= 1;
  CHECK(rvdnav_smooth(owner.context, 0, &image, smoothed.data()) == RVDNAV_ERROR_IMAGE);
}

TEST_CASE("images without a context are checked") {
  const std::vector<uint8_t> pixels(64, 80);
  uint64_t digest = 0;
  uint32_t median = 0;
  rvdnav_fields fields = {};
  fields.struct_size = sizeof fields;
  const auto statuses = [&](const rvdnav_image* image) {
    return std::array{rvdnav_image_digest(image, &digest), rvdnav_noise_median(image, &median),
                      rvdnav_find_fields(image, &fields)};
  };
  const auto all = [](rvdnav_status status) { return std::array{status, status, status}; };
  rvdnav_image image = {pixels.data(), 8, 8, 8};
  CHECK(statuses(&image) == all(RVDNAV_OK));
  CHECK(statuses(nullptr) == all(RVDNAV_ERROR_NULL));
  for (const auto& [width, height, stride] : {std::array{0, 8, 8}, {8, 0, 8}, {8, 8, 7}, {4097, 1, 4097}, {8, -1, 8}}) {
    image = {pixels.data(), width, height, stride};
    CHECK(statuses(&image) == all(RVDNAV_ERROR_IMAGE));
  }
  image = {nullptr, 8, 8, 8};
  CHECK(statuses(&image) == all(RVDNAV_ERROR_NULL));
  image = {pixels.data(), 8, 8, 8};
  CHECK(rvdnav_image_digest(&image, nullptr) == RVDNAV_ERROR_NULL);
  CHECK(rvdnav_noise_median(&image, nullptr) == RVDNAV_ERROR_NULL);
  CHECK(rvdnav_find_fields(&image, nullptr) == RVDNAV_ERROR_NULL);
  fields.struct_size = 4;
  CHECK(rvdnav_find_fields(&image, &fields) == RVDNAV_ERROR_STRUCT_SIZE);
}

TEST_CASE("derivatives with respect to the calibration check what they are given") {
  const rvdnav_rig rig = scene::rig();
  const std::vector<double> zeros(2 * 144 * 2 * 3, 0.0);
  rvdnav_calibration_effect effect = {sizeof effect, 3, zeros.data(), zeros.data(), zeros.data()};
  const rvdnav_measured_line usable = {10.0, 0.3, {{0.1, 0.0, 1.0}, {0.1, 0.2, 1.0}}, 1, 0};
  double out[6] = {};
  const auto status = [&](const rvdnav_measured_line& line) {
    return rvdnav_calibration_derivatives(&rig, &effect, &line, 1, out);
  };
  CHECK(status(usable) == RVDNAV_OK);
  rvdnav_measured_line line = usable;
  line.camera = 2;
  CHECK(status(line) == RVDNAV_ERROR_ARGUMENT);
  line = usable;
  line.ends[1][2] = 0.0;
  CHECK(status(line) == RVDNAV_ERROR_ARGUMENT);
  line = usable;
  line.theta = kNan;
  CHECK(status(line) == RVDNAV_ERROR_ARGUMENT);
  CHECK(rvdnav_calibration_derivatives(nullptr, &effect, &usable, 1, out) == RVDNAV_ERROR_NULL);
  CHECK(rvdnav_calibration_derivatives(&rig, nullptr, &usable, 1, out) == RVDNAV_ERROR_NULL);
  CHECK(rvdnav_calibration_derivatives(&rig, &effect, nullptr, 1, out) == RVDNAV_ERROR_NULL);
  CHECK(rvdnav_calibration_derivatives(&rig, &effect, &usable, 1, nullptr) == RVDNAV_ERROR_NULL);
  effect.shift = nullptr;
  CHECK(status(usable) == RVDNAV_ERROR_NULL);
  effect.parameters = 65;
  CHECK(status(usable) == RVDNAV_ERROR_ARGUMENT);
  effect.parameters = 0;
  CHECK(status(usable) == RVDNAV_OK);
  effect.struct_size = 4;
  CHECK(status(usable) == RVDNAV_ERROR_STRUCT_SIZE);
}

TEST_CASE("seen edges are checked, and placed only where they may be seen") {
  const scene::Owner owner(scene::config(), scene::rig(), nullptr);
  REQUIRE(owner.status == RVDNAV_OK);
  const std::vector<uint8_t> pixels(static_cast<size_t>(scene::kWidth) * scene::kHeight, 80);
  const rvdnav_image image = scene::image(pixels);
  const rvdnav_seen_edge usable = {{{-0.1, 0.0, 1.0}, {0.1, 0.0, 1.0}}, {0.0, 0.0}, 0.0, 0.0, 1, 0};
  std::vector<rvdnav_edge_sample> samples(80);
  rvdnav_edge_coverage coverage = {};
  uint32_t count = 0;
  const auto status = [&](const rvdnav_seen_edge& edge, const rvdnav_image* right, double shortest = 0.0) {
    return rvdnav_sample_edges(owner.context, nullptr, right, &edge, 1, 2.5, shortest, samples.data(), 80, &count,
                               &coverage);
  };
  CHECK(status(usable, &image) == RVDNAV_OK);
  CHECK(count == 0);  // the image is even
  CHECK(coverage.placed == 1);
  CHECK(coverage.profiles > 60);
  CHECK(status(usable, &image, 500.0) == RVDNAV_OK);
  CHECK(coverage.placed == 0);
  CHECK(coverage.profiles == 0);
  rvdnav_seen_edge edge = usable;
  edge.ends[0][2] = 1e-9;
  CHECK(status(edge, &image) == RVDNAV_OK);
  CHECK(coverage.placed == 0);
  CHECK(status(usable, nullptr) == RVDNAV_ERROR_NULL);
  CHECK(status(usable, &image, kNan) == RVDNAV_ERROR_ARGUMENT);
  for (double* value : {&edge.ends[1][0], &edge.ends[1][2], &edge.offset[0], &edge.face, &edge.blur}) {
    edge = usable;
    *value = kNan;
    CHECK(status(edge, &image) == RVDNAV_ERROR_ARGUMENT);
  }
  edge = usable;
  edge.camera = -1;
  CHECK(status(edge, &image) == RVDNAV_ERROR_ARGUMENT);
  edge = usable;
  edge.polarity = 2;
  CHECK(status(edge, &image) == RVDNAV_ERROR_ARGUMENT);
  CHECK(rvdnav_sample_edges(owner.context, nullptr, &image, &usable, 1, 2.5, 0.0, samples.data(), 79, &count,
                            &coverage) == RVDNAV_ERROR_CAPACITY);
  CHECK(count == 80);
  CHECK(rvdnav_sample_edges(owner.context, nullptr, nullptr, nullptr, 0, 2.5, 0.0, nullptr, 0, &count, nullptr) ==
        RVDNAV_OK);
  CHECK(count == 0);
}

TEST_CASE("a stride changes nothing") {
  const scene::Owner owner(scene::config(), scene::rig(), nullptr);
  REQUIRE(owner.status == RVDNAV_OK);
  const std::vector<uint8_t> packed = scene::draw(0, {0.6, 0.01, 0.02, 0.1});
  constexpr int32_t kStride = scene::kWidth + 13;
  std::vector<uint8_t> wide(static_cast<size_t>(kStride) * scene::kHeight, 255);
  for (size_t y = 0; y < scene::kHeight; ++y) {
    std::memcpy(&wide[y * kStride], &packed[y * scene::kWidth], scene::kWidth);
  }
  const rvdnav_image packed_image = scene::image(packed);
  const rvdnav_image wide_image = {wide.data(), scene::kWidth, scene::kHeight, kStride};
  std::vector<uint8_t> a(packed.size());
  std::vector<uint8_t> b(packed.size());
  REQUIRE(rvdnav_smooth(owner.context, 0, &packed_image, a.data()) == RVDNAV_OK);
  REQUIRE(rvdnav_smooth(owner.context, 0, &wide_image, b.data()) == RVDNAV_OK);
  CHECK(a == b);
}

TEST_CASE("an output that is too small says how much is needed") {
  const scene::Owner owner(scene::config(), scene::rig(), nullptr);
  REQUIRE(owner.status == RVDNAV_OK);
  const uint32_t words = rvdnav_edge_row_words(scene::kWidth);
  std::vector<uint32_t> bits(words * size_t{scene::kHeight}, 0);
  for (size_t y = 100; y < 110; ++y) bits[y * words + 5] = 1U << 7;
  const std::vector<uint8_t> direction(static_cast<size_t>(scene::kWidth) * scene::kHeight, 0);
  std::vector<rvdnav_edgel> edgels(10);
  uint32_t count = 0;
  CHECK(rvdnav_rectify_edges(owner.context, 0, bits.data(), direction.data(), edgels.data(), 4, &count) ==
        RVDNAV_ERROR_CAPACITY);
  CHECK(count == 10);
  CHECK(rvdnav_rectify_edges(owner.context, 0, bits.data(), direction.data(), edgels.data(), 10, &count) == RVDNAV_OK);
  CHECK(count == 10);
}
