// Every number that comes in through the C ABI at its extremes, through initialisation and a frame.  Legal or refused,
// nothing may overflow, divide by zero or leave its memory: the sanitizers watch.
#include <doctest/doctest.h>

#include <climits>
#include <cmath>
#include <limits>
#include <random>
#include <utility>
#include <vector>

#include "scene.hpp"

namespace {

constexpr double kInf = std::numeric_limits<double>::infinity();
constexpr double kNan = std::numeric_limits<double>::quiet_NaN();
const std::vector<double> kReals = {0.0,  -0.0,  5e-324, 1e-300, 1e-3, -1.0, 8191.0,
                                    -1e4, 4.3e9, 1e19,   -1e300, kInf, kNan};
const std::vector<int32_t> kIntegers = {INT_MIN, INT_MIN + 1, -65536, -1,    0,     1,       2,       3,
                                        16,      255,         4096,   32767, 65536, 1 << 20, 1 << 24, INT_MAX};

struct Setting {
  const char* name;
  int32_t rvdnav_config::*integer;
  double rvdnav_config::*real;
};

#define INTEGER(field) \
  { #field, &rvdnav_config::field, nullptr }
#define REAL(field) \
  { #field, nullptr, &rvdnav_config::field }
const Setting kSettings[] = {INTEGER(isa),
                             INTEGER(edge_floor),
                             INTEGER(edge_weber_q8),
                             INTEGER(edge_knee),
                             INTEGER(edge_min_run),
                             INTEGER(hough_rho_bins),
                             INTEGER(hough_spread),
                             INTEGER(peak_min_votes),
                             INTEGER(segment_min_length),
                             INTEGER(segment_max_gap),
                             INTEGER(max_edgels),
                             INTEGER(max_peaks),
                             INTEGER(max_segments),
                             INTEGER(max_bars),
                             INTEGER(max_hypotheses),
                             INTEGER(match_half_window),
                             INTEGER(match_row_tolerance),
                             INTEGER(match_min_score_q8),
                             INTEGER(match_uniqueness_q8),
                             INTEGER(match_max_gradient_q8),
                             INTEGER(match_consistency_q8),
                             REAL(range_min),
                             REAL(range_max),
                             REAL(blur_sigma)};
#undef INTEGER
#undef REAL

// A bracket in a small image, so that a frame is quick.
constexpr int32_t kSide = 64;

rvdnav_rig small_rig() {
  rvdnav_rig rig = scene::rig();
  rig.width = rig.height = kSide;
  rig.focal_rect = 66.0;
  for (rvdnav_camera& c : rig.camera) {
    c.fx = c.fy = 66.0;
    c.cx = c.cy = 0.5 * (kSide - 1);
  }
  return rig;
}

// Two frames of bars, one in the other, and some noise.
std::vector<uint8_t> picture(int32_t width, int32_t height) {
  std::mt19937 random(3);
  std::vector<uint8_t> pixels(static_cast<size_t>(width) * static_cast<size_t>(height));
  for (int32_t y = 0; y < height; ++y) {
    for (int32_t x = 0; x < width; ++x) {
      const int32_t rim = std::min(std::min(x, width - 1 - x), std::min(y, height - 1 - y));
      const bool bar = (rim >= 8 && rim < 12) || (rim >= 18 && rim < 22);
      pixels[static_cast<size_t>(y) * static_cast<size_t>(width) + static_cast<size_t>(x)] =
          static_cast<uint8_t>((bar ? 170 : 40) + random() % 8);
    }
  }
  return pixels;
}

const rvdnav_window kWindow = {0, 0, -22.0, 0.1, 8.0, 0.1, -20.0, 20.0};
const rvdnav_model_edge kEdge = {-22.0, -18.0, -22.0, 18.0, 4.0, 0.0, 0, 0};

// Acquisition, tracking, both views together, samples and the surface.
void run_frame(const scene::Owner& owner, const rvdnav_rig& rig, const rvdnav_window& window = kWindow,
               const rvdnav_model_edge& edge = kEdge) {
  const std::vector<uint8_t> pixels = picture(rig.width, rig.height);
  const rvdnav_image image = {pixels.data(), rig.width, rig.height, rig.width};
  const bool stereo = rig.camera_count == 2;
  rvdnav_frame_result frame = {};
  frame.struct_size = sizeof(frame);
  for (const uint32_t windows : {0U, 1U}) {
    rvdnav_view_result views[2] = {};
    bool good = true;
    for (int32_t camera = 0; camera < rig.camera_count; ++camera) {
      views[camera].struct_size = sizeof(views[camera]);
      const rvdnav_status status = rvdnav_view(owner.context, camera, &image, &window, windows, &views[camera]);
      CHECK((status == RVDNAV_OK || (windows == 1 && status == RVDNAV_ERROR_ARGUMENT)));
      good = good && status == RVDNAV_OK;
    }
    if (!good) continue;
    CHECK(rvdnav_join(owner.context, &image, stereo ? &image : nullptr, &views[0], stereo ? &views[1] : nullptr,
                      windows == 0 ? 1 : 0, &frame) == RVDNAV_OK);
  }
  std::vector<rvdnav_edge_sample> samples(64);
  uint32_t count = 0;
  const rvdnav_status sampled =
      rvdnav_measure_edges(owner.context, 0, &image, &edge, 1, 3.5, 1.0, 0.0, samples.data(), 64, &count);
  CHECK((sampled == RVDNAV_OK || sampled == RVDNAV_ERROR_ARGUMENT));
  if (stereo) {
    rvdnav_match match = {};
    match.x = edge.x0;
    match.y = edge.y0;
    match.bar = -1;
    const rvdnav_status matched = rvdnav_correlate(owner.context, &image, &image, &match, 1);
    CHECK((matched == RVDNAV_OK || matched == RVDNAV_ERROR_ARGUMENT));
    size_t size = 0;
    REQUIRE(rvdnav_surface_size(owner.context, &size) == RVDNAV_OK);
    const std::unique_ptr<void, scene::Owner::Free> memory(std::aligned_alloc(64, (size + 63) / 64 * 64));
    std::vector<rvdnav_surface_point> points(4096);
    uint32_t crossings = 0;
    const rvdnav_status surface =
        rvdnav_surface(owner.context, &image, &image, memory.get(), size, points.data(), 4096, &count, &crossings);
    CHECK((surface == RVDNAV_OK || surface == RVDNAV_ERROR_CAPACITY));
  }
  CHECK(owner.guard_intact());
}

// Whether the structures are accepted; if so, a frame has been run.
bool survives(const rvdnav_config& config, const rvdnav_rig& rig, const rvdnav_target& target) {
  const scene::Owner owner(config, rig, &target);
  if (owner.status != RVDNAV_OK) return false;
  run_frame(owner, rig);
  return true;
}

std::vector<double*> numbers_of(rvdnav_rig& rig) {
  std::vector<double*> numbers = {&rig.focal_rect, &rig.baseline};
  for (rvdnav_camera& c : rig.camera) {
    numbers.insert(numbers.end(), {&c.fx, &c.fy, &c.cx, &c.cy, &c.k1, &c.k2, &c.p1, &c.p2});
    for (double& r : c.R_rect_cam) numbers.push_back(&r);
  }
  return numbers;
}

}  // namespace

TEST_CASE("every setting has a range, whose ends are taken and beyond which it is refused") {
  const rvdnav_target target = scene::target();
  for (const Setting& setting : kSettings) {
    CAPTURE(setting.name);
    double low = 0, high = 0;
    REQUIRE(rvdnav_config_range(setting.name, &low, &high) == RVDNAV_OK);
    const auto accepted = [&](double value) {
      rvdnav_config config = scene::config();
      if (setting.integer != nullptr) {
        config.*setting.integer = static_cast<int32_t>(value);
      } else {
        config.*setting.real = value;
        if (setting.real == &rvdnav_config::range_min && value > 1.0) config.range_max = 1e4;
        if (setting.real == &rvdnav_config::range_max && value < 1.0) config.range_min = 1e-3;
      }
      const bool ends = (setting.real == &rvdnav_config::range_min && value == 1e4) ||
                        (setting.real == &rvdnav_config::range_max && value == 1e-3);
      const bool foreign = setting.integer == &rvdnav_config::isa && value > 1.0;
      return survives(config, small_rig(), target) || ends || foreign;
    };
    CHECK(accepted(low));
    CHECK(accepted(high));
    if (setting.integer != nullptr) {
      CHECK(!accepted(low - 1.0));
      if (setting.integer != &rvdnav_config::isa) CHECK(!accepted(high + 1.0));
    } else {
      CHECK(!accepted(std::nextafter(low, -kInf)));
      CHECK(!accepted(std::nextafter(high, kInf)));
      CHECK(!accepted(kNan));
    }
  }
  double low = 0, high = 0;
  CHECK(rvdnav_config_range("struct_size", &low, &high) == RVDNAV_ERROR_ARGUMENT);
}

TEST_CASE("settings at their extremes, one by one and several at once") {
  const rvdnav_target target = scene::target();
  for (const Setting& setting : kSettings) {
    CAPTURE(setting.name);
    for (size_t i = 0; i < std::max(kReals.size(), kIntegers.size()); ++i) {
      rvdnav_config config = scene::config();
      if (setting.integer != nullptr && i < kIntegers.size()) config.*setting.integer = kIntegers[i];
      if (setting.real != nullptr && i < kReals.size()) config.*setting.real = kReals[i];
      survives(config, small_rig(), target);
    }
  }
  std::mt19937 random(11);
  for (int round = 0; round < 25; ++round) {
    rvdnav_config config = scene::config();
    for (const Setting& setting : kSettings) {
      double low = 0, high = 0;
      REQUIRE(rvdnav_config_range(setting.name, &low, &high) == RVDNAV_OK);
      if (setting.integer == &rvdnav_config::isa || random() % 2 == 0) continue;
      if (setting.integer == &rvdnav_config::max_edgels) high = 1 << 16;
      const double value = random() % 2 == 0 ? low : high;
      if (setting.integer != nullptr) config.*setting.integer = static_cast<int32_t>(value);
      if (setting.real != nullptr) config.*setting.real = value;
    }
    survives(config, small_rig(), target);
  }
}

TEST_CASE("rigs at their extremes") {
  const rvdnav_target target = scene::target();
  rvdnav_rig rig = small_rig();
  for (size_t i = 0; i < numbers_of(rig).size(); ++i) {
    CAPTURE(i);
    for (const double value : kReals) {
      rig = small_rig();
      *numbers_of(rig)[i] = value;
      survives(scene::config(), rig, target);
    }
  }
  for (int32_t rvdnav_rig::*field : {&rvdnav_rig::width, &rvdnav_rig::height, &rvdnav_rig::camera_count}) {
    for (const int32_t value : kIntegers) {
      rig = small_rig();
      rig.*field = value;
      const bool accepted = survives(scene::config(), rig, target);
      if (field == &rvdnav_rig::camera_count) CHECK(accepted == (value == 2));
      if (field != &rvdnav_rig::camera_count) CHECK(accepted == (value >= 16 && value <= 4096));
    }
  }
  std::mt19937 random(12);
  for (int round = 0; round < 60; ++round) {
    rig = small_rig();
    std::vector<double*> numbers = numbers_of(rig);
    for (int changes = 0; changes < 3; ++changes) {
      // Not the rotations: next to none of them would be accepted.
      const size_t which = random() % 18;
      *numbers[which < 10 ? which : which + 9] = kReals[random() % kReals.size()];
    }
    survives(scene::config(), rig, target);
  }
}

TEST_CASE("targets at their extremes") {
  for (size_t i = 0; i < 25; ++i) {
    CAPTURE(i);
    for (const double value : kReals) {
      rvdnav_target target = scene::target();
      (i < 12 ? target.outer[i / 3][i % 3] : i < 24 ? target.inner[i / 3 - 4][i % 3] : target.thickness) = value;
      const bool accepted = survives(scene::config(), small_rig(), target);
      if (!(std::abs(value) <= 1e3)) CHECK(!accepted);
    }
  }
  rvdnav_target huge = scene::target();
  for (int32_t i = 0; i < 4; ++i) {
    for (int32_t k = 0; k < 3; ++k) {
      huge.outer[i][k] *= 5e3;
      huge.inner[i][k] *= 5e3;
    }
  }
  CHECK(survives(scene::config(), small_rig(), huge));
}

TEST_CASE("windows and model edges at their extremes") {
  const rvdnav_target target = scene::target();
  const scene::Owner owner(scene::config(), small_rig(), &target);
  REQUIRE(owner.status == RVDNAV_OK);
  for (const double value : kReals) {
    for (double rvdnav_window::*field : {&rvdnav_window::rho, &rvdnav_window::theta, &rvdnav_window::half_rho,
                                         &rvdnav_window::half_theta, &rvdnav_window::t_min, &rvdnav_window::t_max}) {
      rvdnav_window window = kWindow;
      window.*field = value;
      run_frame(owner, small_rig(), window);
    }
    for (double rvdnav_model_edge::*field :
         {&rvdnav_model_edge::x0, &rvdnav_model_edge::y0, &rvdnav_model_edge::x1, &rvdnav_model_edge::y1,
          &rvdnav_model_edge::face, &rvdnav_model_edge::blur}) {
      rvdnav_model_edge edge = kEdge;
      edge.*field = value;
      run_frame(owner, small_rig(), kWindow, edge);
    }
  }
}

TEST_CASE("the blur of a model edge has a range") {
  const rvdnav_target target = scene::target();
  const scene::Owner owner(scene::config(), scene::rig(), &target);
  REQUIRE(owner.status == RVDNAV_OK);
  const std::vector<uint8_t> pixels = scene::draw(0, {0.8, 0.0, 0.0, 0.0});
  const rvdnav_image image = scene::image(pixels);
  rvdnav_edge_sample samples[64];
  uint32_t count = 0;
  const auto measure = [&](double blur) {
    rvdnav_model_edge edge = kEdge;
    edge.blur = blur;
    return rvdnav_measure_edges(owner.context, 0, &image, &edge, 1, 3.5, 1.0, 0.0, samples, 64, &count);
  };
  for (const double blur : {0.0, 1e-300, 0.7, 10.0}) CHECK(measure(blur) == RVDNAV_OK);
  for (const double blur : {-1e-3, 10.001, static_cast<double>(INFINITY), std::nan("")}) {
    CHECK(measure(blur) == RVDNAV_ERROR_ARGUMENT);
  }
}
