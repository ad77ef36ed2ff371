// The surface from outside: textured planes and steps whose place in space is known exactly.
#include <doctest/doctest.h>

#include <algorithm>
#include <cmath>
#include <functional>

#include "lens.hpp"
#include "plain.hpp"
#include "sample_rig.hpp"
#include "scene.hpp"
#include "stepped_images.hpp"

using namespace rvdnav;

namespace {

using Texture = std::function<double(double x, double y)>;
using Disparity = std::function<double(double x, double y)>;  // at a rectified place of the left view

// Smooth, and nowhere like itself: waves of many directions and lengths.
Texture waves(uint64_t seed) {
  struct Wave {
    double kx, ky, phase;
  };
  plain::Random random(seed);
  std::vector<Wave> all;
  for (int i = 0; i < 40; ++i) {
    const double length = std::exp(random.real(std::log(7.0), std::log(60.0))), angle = random.real(0.0, M_PI);
    all.push_back(
        {2.0 * M_PI / length * std::cos(angle), 2.0 * M_PI / length * std::sin(angle), random.real(-M_PI, M_PI)});
  }
  return [all](double x, double y) {
    double sum = 0.0;
    for (const Wave& w : all) sum += std::sin(w.kx * x + w.ky * y + w.phase);
    return 120.0 + 12.0 * sum;
  };
}

// A view of a texture that is given in rectified coordinates of this camera, through its lens.
plain::Grey draw(const rvdnav_rig& rig, int camera, const Texture& texture, double noise, uint64_t seed) {
  plain::Random random(seed);
  plain::Grey image(rig.width, rig.height);
  for (int v = 0; v < rig.height; ++v) {
    for (int u = 0; u < rig.width; ++u) {
      double x = 0.0, y = 0.0;
      raw_to_rect(rig, camera, u, v, &x, &y);
      const double grey = std::round(texture(x, y) + noise * stepped::normal(random));
      image.at(u, v) = static_cast<uint8_t>(std::clamp(grey, 0.0, 255.0));
    }
  }
  return image;
}

// The left place that the right view's (x, y) shows, for a disparity of slope below one.
double left_of(const Disparity& disparity, double x, double y) {
  double left = x;
  for (int i = 0; i < 60; ++i) left = x + disparity(left, y);
  return left;
}

rvdnav_image image_of(const plain::Grey& grey) { return {grey.pixels.data(), grey.w, grey.h, grey.w}; }

struct Surface {
  rvdnav_status status = RVDNAV_OK;
  std::vector<rvdnav_surface_point> points;
  uint32_t crossings = 0;
};

Surface reconstruct(const rvdnav_rig& rig, const plain::Grey& left, const plain::Grey& right,
                    const rvdnav_config& config = scene::config()) {
  const scene::Owner owner(config, rig, nullptr);
  REQUIRE(owner.status == RVDNAV_OK);
  size_t size = 0;
  REQUIRE(rvdnav_surface_size(owner.context, &size) == RVDNAV_OK);
  constexpr size_t kGuard = 64;
  auto* memory = static_cast<uint8_t*>(std::aligned_alloc(64, (size + kGuard + 63) / 64 * 64));
  std::fill(memory + size, memory + size + kGuard, uint8_t{0xa5});
  Surface out;
  out.points.resize(size_t{1} << 17);
  uint32_t count = 0;
  const rvdnav_image l = image_of(left), r = image_of(right);
  out.status = rvdnav_surface(owner.context, &l, &r, memory, size, out.points.data(),
                              static_cast<uint32_t>(out.points.size()), &count, &out.crossings);
  CHECK(std::all_of(memory + size, memory + size + kGuard, [](uint8_t byte) { return byte == 0xa5; }));
  CHECK(owner.guard_intact());
  std::free(memory);
  REQUIRE(out.status == RVDNAV_OK);
  out.points.resize(count);
  return out;
}

// A narrower rig, so that drawing is quick.
rvdnav_rig small_rig(const rvdnav_rig& of) {
  rvdnav_rig rig = of;
  for (rvdnav_camera& c : rig.camera) {
    c.cx += (320 - rig.width) / 2.0;
    c.cy += (200 - rig.height) / 2.0;
  }
  rig.width = 320;
  rig.height = 200;
  return rig;
}

struct Errors {
  size_t count;
  double median, bias;  // pixels of disparity
  double within_3_sigma;
  double sigma;  // median
};

Errors judge(const Surface& surface, const Disparity& disparity) {
  std::vector<double> errors, sizes, sigmas;
  size_t within = 0;
  for (const rvdnav_surface_point& p : surface.points) {
    const double error = p.disparity_q8 / 256.0 - disparity(p.x_q8 / 256.0, p.y_q8 / 256.0);
    errors.push_back(error);
    sizes.push_back(std::abs(error));
    sigmas.push_back(p.sigma_disparity);
    within += std::abs(error) <= 3.0 * p.sigma_disparity;
  }
  if (errors.empty()) return {};
  const auto median = [](std::vector<double> v) {
    std::nth_element(v.begin(), v.begin() + static_cast<ptrdiff_t>(v.size() / 2), v.end());
    return v[v.size() / 2];
  };
  return {errors.size(), median(sizes), median(errors),
          static_cast<double>(within) / static_cast<double>(errors.size()), median(sigmas)};
}

}  // namespace

TEST_CASE("a tilted textured plane through a real lens comes out where it is, with honest sigmas") {
  const rvdnav_rig rig = small_rig(sample_rig());
  const Disparity disparity = [](double x, double y) { return 80.0 + 0.06 * x - 0.04 * y; };
  const Texture texture = waves(301);
  for (const double noise : {0.0, 2.0}) {
    const plain::Grey left = draw(rig, 0, texture, noise, 302);
    const plain::Grey right = draw(
        rig, 1, [&](double x, double y) { return texture(left_of(disparity, x, y), y); }, noise, 303);
    const Surface surface = reconstruct(rig, left, right);
    const Errors e = judge(surface, disparity);
    CHECK(e.count > 2500);
    CHECK(e.median < (noise > 0.0 ? 0.1 : 0.04));
    CHECK(std::abs(e.bias) < 0.01);
    CHECK(e.within_3_sigma > 0.985);
    CHECK(e.sigma < (noise > 0.0 ? 0.15 : 0.12));
    for (const rvdnav_surface_point& p : surface.points) {
      const double d = p.disparity_q8 / 256.0, depth = rig.focal_rect * rig.baseline / d;
      CHECK(p.p_W[0] == doctest::Approx(depth).epsilon(1e-9));
      CHECK(p.p_W[1] == doctest::Approx(depth * p.y_q8 / 256.0 / rig.focal_rect).epsilon(1e-9).scale(0.1));
      CHECK(p.p_W[2] ==
            doctest::Approx(rig.baseline - depth * p.x_q8 / 256.0 / rig.focal_rect).epsilon(1e-9).scale(0.1));
      // Along the ray, a change of the disparity by sigma moves the point by sigma.
      const double ray = std::hypot(p.p_W[0], p.p_W[1], p.p_W[2] - rig.baseline);
      CHECK(p.sigma == doctest::Approx(ray * p.sigma_disparity / d).epsilon(1e-9));
    }
  }
}

TEST_CASE("a near square before a far plane: both are found, and hardly anything between") {
  const rvdnav_rig rig = small_rig(scene::rig());
  const Texture far_texture = waves(311), near_texture = waves(312);
  const auto on_square = [](double x, double y) { return std::abs(x - 60.0) < 35.0 && std::abs(y) < 40.0; };
  constexpr double kFar = 60.0, kNear = 84.0;
  const plain::Grey left = draw(
      rig, 0, [&](double x, double y) { return on_square(x, y) ? near_texture(x, y) : far_texture(x, y); }, 1.5, 313);
  const plain::Grey right = draw(
      rig, 1,
      [&](double x, double y) {
        return on_square(x + kNear, y) ? near_texture(x + kNear, y) : far_texture(x + kFar, y);
      },
      1.5, 314);
  size_t near = 0, far = 0, neither = 0;
  for (const rvdnav_surface_point& p : reconstruct(rig, left, right).points) {
    const double d = p.disparity_q8 / 256.0;
    const double reach = std::max(3.0 * p.sigma_disparity, 0.3);
    const bool is_near = std::abs(d - kNear) < reach, is_far = std::abs(d - kFar) < reach;
    const double x = p.x_q8 / 256.0, y = p.y_q8 / 256.0;
    near += is_near && on_square(x, y);
    far += is_far && !on_square(x, y);
    neither += !is_near && !is_far;
  }
  CHECK(near > 250);
  CHECK(far > 1200);
  CHECK(neither < (near + far) / 50);
}

TEST_CASE("stripes along the rows, a regular grid and unrelated noise give no surface to believe") {
  const rvdnav_rig rig = small_rig(scene::rig());
  const auto both = [&](const Texture& texture, uint64_t seed) {
    const plain::Grey left = draw(rig, 0, texture, 1.0, seed);
    const plain::Grey right = draw(
        rig, 1, [&](double x, double y) { return texture(x + 70.0, y); }, 1.0, seed + 1);
    return reconstruct(rig, left, right);
  };
  CHECK(both([](double, double y) { return 120.0 + 80.0 * std::sin(y / 4.0); }, 321).points.empty());
  const Surface grid = both([](double x, double) { return 120.0 + 80.0 * std::sin(x / 2.0); }, 323);
  CHECK(grid.points.empty());
  const double half_period = 2.0 * 3.14159265;  // a zero crossing in each, of every row
  CHECK(grid.crossings == doctest::Approx(rig.height * rig.width / half_period).epsilon(0.05));
  plain::Random random(325);
  const plain::Grey left = plain::random_grey(random, rig.width, rig.height);
  const plain::Grey right = plain::random_grey(random, rig.width, rig.height);
  CHECK(reconstruct(rig, left, right).points.size() < 20);
  const plain::Grey dark(rig.width, rig.height, 7);
  CHECK(reconstruct(rig, dark, dark).crossings == 0);
}

TEST_CASE("the range gate bounds the search") {
  const rvdnav_rig rig = small_rig(scene::rig());
  const Texture texture = waves(331);
  const plain::Grey left = draw(rig, 0, texture, 1.0, 332);
  const plain::Grey right = draw(
      rig, 1, [&](double x, double y) { return texture(x + 70.0, y); }, 1.0, 333);
  CHECK(reconstruct(rig, left, right).points.size() > 2000);
  rvdnav_config config = scene::config();
  config.range_max = rig.focal_rect * rig.baseline / 76.0;
  for (const rvdnav_surface_point& p : reconstruct(rig, left, right, config).points) CHECK(p.disparity_q8 >= 76 * 256);
}

TEST_CASE("too little room says how much is needed, and gives the first points") {
  const rvdnav_rig rig = small_rig(scene::rig());
  const Texture texture = waves(341);
  const plain::Grey left = draw(rig, 0, texture, 1.0, 342);
  const plain::Grey right = draw(
      rig, 1, [&](double x, double y) { return texture(x + 70.0, y); }, 1.0, 343);
  const Surface all = reconstruct(rig, left, right);
  const scene::Owner owner(scene::config(), rig, nullptr);
  size_t size = 0;
  REQUIRE(rvdnav_surface_size(owner.context, &size) == RVDNAV_OK);
  void* memory = std::aligned_alloc(64, (size + 63) / 64 * 64);
  std::vector<rvdnav_surface_point> some(10);
  uint32_t count = 0, crossings = 0;
  const rvdnav_image l = image_of(left), r = image_of(right);
  CHECK(rvdnav_surface(owner.context, &l, &r, memory, size, some.data(), 10, &count, &crossings) ==
        RVDNAV_ERROR_CAPACITY);
  CHECK(count == all.points.size());
  CHECK(crossings == all.crossings);
  for (size_t i = 0; i < some.size(); ++i) CHECK(some[i].x_q8 == all.points[i].x_q8);

  const auto call = [&](const rvdnav_image* a, void* block, size_t bytes, uint32_t* n) {
    return rvdnav_surface(owner.context, a, &r, block, bytes, some.data(), 10, n, &crossings);
  };
  CHECK(call(nullptr, memory, size, &count) == RVDNAV_ERROR_NULL);
  CHECK(call(&l, nullptr, size, &count) == RVDNAV_ERROR_NULL);
  CHECK(call(&l, memory, size, nullptr) == RVDNAV_ERROR_NULL);
  CHECK(call(&l, memory, size - 1, &count) == RVDNAV_ERROR_MEMORY);
  CHECK(call(&l, static_cast<uint8_t*>(memory) + 8, size, &count) == RVDNAV_ERROR_MEMORY);
  rvdnav_image narrow = l;
  narrow.width -= 1;
  CHECK(call(&narrow, memory, size, &count) == RVDNAV_ERROR_IMAGE);
  CHECK(rvdnav_surface(owner.context, &l, &r, memory, size, nullptr, 10, &count, &crossings) == RVDNAV_ERROR_NULL);
  CHECK(rvdnav_surface(owner.context, &l, &r, memory, size, some.data(), 10, &count, nullptr) == RVDNAV_ERROR_NULL);
  CHECK(rvdnav_surface_size(owner.context, nullptr) == RVDNAV_ERROR_NULL);
  CHECK(rvdnav_surface_size(nullptr, &size) == RVDNAV_ERROR_NULL);

  const scene::Owner alone(scene::config(), scene::rig(1), nullptr);
  CHECK(rvdnav_surface_size(alone.context, &size) == RVDNAV_ERROR_ARGUMENT);
  CHECK(rvdnav_surface(alone.context, &l, &r, memory, size, some.data(), 10, &count, &crossings) ==
        RVDNAV_ERROR_ARGUMENT);
  std::free(memory);
}

TEST_CASE("the smallest and odd images go through") {
  plain::Random random(351);
  for (const auto& [w, h] : {std::pair{16, 16}, std::pair{203, 61}, std::pair{17, 90}}) {
    rvdnav_rig rig = scene::rig();
    rig.width = w;
    rig.height = h;
    for (rvdnav_camera& c : rig.camera) {
      c.cx = 0.5 * (w - 1);
      c.cy = 0.5 * (h - 1);
    }
    rvdnav_config config = scene::config();
    config.match_min_score_q8 = 0;
    config.match_uniqueness_q8 = 256;
    reconstruct(rig, plain::random_grey(random, w, h), plain::random_grey(random, w, h), config);
  }
}
