// Arbitrary but legal data through the stages: nothing is written outside the memory given.  The sanitizers watch.
#include <doctest/doctest.h>

#include <random>

#include "scene.hpp"

namespace {

constexpr int kOddWidth = 203;  // no multiple of a word
constexpr int kOddHeight = 61;

rvdnav_rig odd_rig() {
  rvdnav_rig rig = scene::rig();
  rig.width = kOddWidth;
  rig.height = kOddHeight;
  for (rvdnav_camera& c : rig.camera) {
    c.cx = 0.5 * (kOddWidth - 1);
    c.cy = 0.5 * (kOddHeight - 1);
  }
  return rig;
}

template <typename T>
std::vector<T> noise(std::mt19937& random, size_t n) {
  std::vector<T> out(n);
  for (T& value : out) value = static_cast<T>(random());
  return out;
}

}  // namespace

TEST_CASE("noise goes through every image stage") {
  std::mt19937 random(7);
  const scene::Owner owner(scene::config(), odd_rig(), nullptr);
  REQUIRE(owner.status == RVDNAV_OK);
  constexpr size_t kPixels = size_t{kOddWidth} * kOddHeight;
  const size_t words = rvdnav_edge_row_words(kOddWidth);
  for (int round = 0; round < 5; ++round) {
    const std::vector<uint8_t> pixels = noise<uint8_t>(random, kPixels);
    const rvdnav_image image = {pixels.data(), kOddWidth, kOddHeight, kOddWidth};
    std::vector<uint8_t> smoothed(kPixels);
    std::vector<uint8_t> direction(kPixels);
    std::vector<uint32_t> bits(words * kOddHeight);
    REQUIRE(rvdnav_smooth(owner.context, 0, &image, smoothed.data()) == RVDNAV_OK);
    REQUIRE(rvdnav_detect_edges(owner.context, 0, pixels.data(), bits.data(), direction.data()) == RVDNAV_OK);
    REQUIRE(rvdnav_filter_edges(owner.context, 0, bits.data()) == RVDNAV_OK);
    REQUIRE(rvdnav_thin(owner.context, 0, bits.data()) == RVDNAV_OK);
  }
  CHECK(owner.guard_intact());
}

TEST_CASE("edge bits up to the border go through, those beyond it are refused") {
  std::mt19937 random(8);
  const scene::Owner owner(scene::config(), odd_rig(), nullptr);
  REQUIRE(owner.status == RVDNAV_OK);
  const size_t words = rvdnav_edge_row_words(kOddWidth);
  std::vector<uint32_t> bits = noise<uint32_t>(random, words * kOddHeight);
  const std::vector<uint8_t> direction = noise<uint8_t>(random, size_t{kOddWidth} * kOddHeight);
  CHECK(rvdnav_filter_edges(owner.context, 0, bits.data()) == RVDNAV_ERROR_ARGUMENT);
  CHECK(rvdnav_thin(owner.context, 0, bits.data()) == RVDNAV_ERROR_ARGUMENT);
  for (size_t y = 0; y < kOddHeight; ++y) bits[y * words + words - 1] &= (1U << (kOddWidth % 32)) - 1;
  std::vector<rvdnav_edgel> edgels(size_t{kOddWidth} * kOddHeight);
  uint32_t count = 0;
  REQUIRE(rvdnav_rectify_edges(owner.context, 1, bits.data(), direction.data(), edgels.data(),
                               static_cast<uint32_t>(edgels.size()), &count) == RVDNAV_OK);
  CHECK(count > edgels.size() / 3);
  CHECK(rvdnav_filter_edges(owner.context, 1, bits.data()) == RVDNAV_OK);
  CHECK(rvdnav_thin(owner.context, 1, bits.data()) == RVDNAV_OK);
  CHECK(owner.guard_intact());
}

TEST_CASE("edgels anywhere and windows anywhere go through Hough space") {
  std::mt19937 random(9);
  rvdnav_config config = scene::config();
  const scene::Owner owner(config, odd_rig(), nullptr);
  REQUIRE(owner.status == RVDNAV_OK);
  REQUIRE(rvdnav_context_config(owner.context, &config) == RVDNAV_OK);
  std::vector<rvdnav_edgel> edgels(3000);
  for (rvdnav_edgel& e : edgels) {
    e = {static_cast<int32_t>(random()), static_cast<int32_t>(random()), static_cast<uint8_t>(random()), {}};
    if (random() % 2 == 0) e = {e.x_q5 >> 17, e.y_q5 >> 17, e.direction, {}};
  }
  edgels[0] = {INT32_MIN, INT32_MIN, 96, {}};
  const auto count = static_cast<uint32_t>(edgels.size());
  std::vector<uint16_t> accumulator(size_t{180} * static_cast<size_t>(config.hough_rho_bins));
  REQUIRE(rvdnav_hough_vote(owner.context, edgels.data(), count, accumulator.data()) == RVDNAV_OK);
  std::vector<rvdnav_peak> peaks(1 << 14);
  uint32_t peak_count = 0;
  CHECK(rvdnav_hough_peaks(owner.context, accumulator.data(), peaks.data(), 1U << 14, &peak_count) == RVDNAV_OK);
  accumulator = noise<uint16_t>(random, accumulator.size());
  const rvdnav_status status =
      rvdnav_hough_peaks(owner.context, accumulator.data(), peaks.data(), 1U << 14, &peak_count);
  CHECK((status == RVDNAV_OK || status == RVDNAV_ERROR_CAPACITY));

  std::uniform_real_distribution<double> wide(-9e3, 9e3);
  for (int round = 0; round < 50; ++round) {
    rvdnav_window window = {};
    window.rho = round % 2 == 0 ? wide(random) : wide(random) * 0.01;
    window.theta = round % 3 == 0 ? wide(random) : wide(random) * 2e-4;
    window.half_rho = std::abs(wide(random)) * (round % 2 == 0 ? 1.0 : 1e-3);
    window.half_theta = std::abs(wide(random)) * (round % 2 == 0 ? 1.0 : 1e-5);
    window.t_min = -std::abs(wide(random));
    window.t_max = std::abs(wide(random));
    CHECK(rvdnav_hough_track(owner.context, 0, edgels.data(), count, &window, 1, peaks.data()) == RVDNAV_OK);
  }
  rvdnav_window bad = {};
  bad.theta = std::nan("");
  CHECK(rvdnav_hough_track(owner.context, 0, edgels.data(), count, &bad, 1, peaks.data()) == RVDNAV_ERROR_ARGUMENT);
  bad = {};
  bad.edge = RVDNAV_EDGES;
  CHECK(rvdnav_hough_track(owner.context, 0, edgels.data(), count, &bad, 1, peaks.data()) == RVDNAV_ERROR_ARGUMENT);
  CHECK(owner.guard_intact());
}

TEST_CASE("peaks and segments beyond their range are refused, whatever they would lead to") {
  const rvdnav_target target = scene::target();
  const scene::Owner owner(scene::config(), odd_rig(), &target);
  REQUIRE(owner.status == RVDNAV_OK);
  rvdnav_segment segments[4];
  uint32_t count = 0;
  const auto extract = [&](const rvdnav_peak& peak) {
    return rvdnav_extract_segments(owner.context, 0, nullptr, 0, &peak, 1, segments, 4, &count);
  };
  CHECK(extract({16384 << 8, 360 << 8, 20}) == RVDNAV_OK);
  CHECK(extract({INT32_MIN, 0, 20}) == RVDNAV_ERROR_ARGUMENT);
  CHECK(extract({0, INT32_MAX, 20}) == RVDNAV_ERROR_ARGUMENT);

  // The two sides of a bar, one of them disturbed.
  const rvdnav_segment side = {-50.0, 0.1, -40.0, 40.0, 1, 60, 0.3};
  const auto find = [&](double rvdnav_segment::*field, double value) {
    rvdnav_segment pair[2] = {side, side};
    pair[1].rho = -42.0;
    pair[1].polarity = -1;
    pair[1].*field = value;
    rvdnav_bar bars[4];
    return rvdnav_find_bars(owner.context, 0, pair, 2, bars, 4, &count);
  };
  CHECK(find(&rvdnav_segment::theta, 0.1) == RVDNAV_OK);
  CHECK(count == 1);
  for (const double value : {1e300, -7.0, static_cast<double>(INFINITY), std::nan("")}) {
    CHECK(find(&rvdnav_segment::theta, value) == RVDNAV_ERROR_ARGUMENT);
  }
  for (double rvdnav_segment::*field : {&rvdnav_segment::rho, &rvdnav_segment::t_min, &rvdnav_segment::t_max}) {
    CHECK(find(field, -1e5) == RVDNAV_ERROR_ARGUMENT);
    CHECK(find(field, std::nan("")) == RVDNAV_ERROR_ARGUMENT);
  }
}
