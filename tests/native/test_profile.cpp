#include <doctest/doctest.h>

#include <cmath>
#include <vector>

#include "profile.hpp"
#include "sample_rig.hpp"
#include "stepped_images.hpp"

using namespace rvdnav;
using stepped::draw;
using stepped::small_rig;

namespace {

constexpr double kBlur = 0.7;  // of an edge as configured: the lens and the pixel's own width together
const double kLensBlur = std::sqrt(kBlur * kBlur - 1.0 / 12.0);
constexpr ProfileSettings kSettings = {3.5, 1.0, kBlur};

// A model edge along a line, `off` pixels from it, so that profiles run towards the line's normal.
rvdnav_model_edge edge_along(const Line2& line, double off, double t_from, double t_to, int32_t polarity = 0,
                             double face = 0.0) {
  const Eigen::Vector2d a = line.at(t_to) + off * line.normal;
  const Eigen::Vector2d b = line.at(t_from) + off * line.normal;
  return {a.x(), a.y(), b.x(), b.y(), face, 0.0, polarity, 0};
}

std::vector<rvdnav_edge_sample> measure(const rvdnav_rig& rig, const plain::Grey& image, const rvdnav_model_edge& edge,
                                        const ProfileSettings& settings = kSettings, int camera = 0) {
  std::vector<rvdnav_edge_sample> samples(512);
  const ProfileCount count = measure_edge(rig, camera, image.view(), edge, 3, settings, samples.data(), 512);
  CHECK(count.found <= count.on_image);
  samples.resize(count.found);
  return samples;
}

struct Statistics {
  double mean, deviation;
};

// Of the samples' distances from the true line.
Statistics distances(const std::vector<rvdnav_edge_sample>& samples, const Line2& line) {
  double sum = 0.0, square = 0.0;
  for (const rvdnav_edge_sample& s : samples) {
    const double d = line.distance({s.x, s.y});
    sum += d;
    square += d * d;
  }
  const auto n = static_cast<double>(samples.size());
  return {sum / n, std::sqrt(square / n - sum * sum / (n * n))};
}

// The samples where their steps stand once the grey beside them may slope.
std::vector<rvdnav_edge_sample> sloped(std::vector<rvdnav_edge_sample> samples) {
  for (rvdnav_edge_sample& s : samples) {
    s.x += s.slope_shift * s.nx;
    s.y += s.slope_shift * s.ny;
  }
  return samples;
}

}  // namespace

TEST_CASE("a step is found where it is, in every direction and phase of the pixels") {
  plain::Random random(80);
  const rvdnav_rig rig = small_rig();
  double worst = 0.0;
  for (int i = 0; i < 24; ++i) {
    const Line2 line = Line2::from_angle(random.real(-15, 15), random.real(-M_PI, M_PI));
    const double rise = i % 2 == 0 ? 110.0 : -60.0;
    const plain::Grey image = draw(rig, 0, line, {rise > 0 ? 40.0 : 160.0, kLensBlur, {{0.0, rise}}}, 1.5, random);
    const double off = random.real(-1.5, 1.5);
    const auto samples = measure(rig, image, edge_along(line, off, -35, 35));
    REQUIRE(samples.size() >= 68);
    const Statistics s = distances(samples, line);
    worst = std::fmax(worst, std::abs(s.mean));
    CHECK(s.deviation < 0.12);
    double scaled = 0.0;
    for (const rvdnav_edge_sample& sample : samples) {
      CHECK(sample.edge == 3);
      CHECK(sample.polarity == (rise > 0 ? 1 : -1));
      CHECK(sample.contrast == doctest::Approx(std::abs(rise)).epsilon(0.25));
      CHECK(sample.nx == doctest::Approx(line.normal.x()));
      CHECK(sample.ny == doctest::Approx(line.normal.y()));
      const double distance = line.distance({sample.x, sample.y});
      CHECK(sample.offset == doctest::Approx(distance - off));
      scaled += distance * distance / (sample.sigma * sample.sigma);
    }
    // Each profile says truly how much it knows.
    scaled = std::sqrt(scaled / static_cast<double>(samples.size()));
    CHECK(scaled > 0.4);
    CHECK(scaled < 1.6);
  }
  CHECK(worst < 0.03);
}

TEST_CASE("a blur other than the expected one moves nothing") {
  plain::Random random(81);
  const rvdnav_rig rig = small_rig();
  for (const double blur : {0.35, 0.5, 0.9, 1.1}) {
    for (int i = 0; i < 4; ++i) {
      const Line2 line = Line2::from_angle(random.real(-10, 10), random.real(-M_PI, M_PI));
      const plain::Grey image = draw(rig, 0, line, {30.0, blur, {{0.0, 120.0}}}, 1.5, random);
      const auto samples = measure(rig, image, edge_along(line, random.real(-1, 1), -35, 35));
      REQUIRE(samples.size() >= 68);
      CHECK(std::abs(distances(samples, line).mean) < 0.03);
    }
  }
}

TEST_CASE("the other side of a narrow bar pulls little") {
  plain::Random random(82);
  const rvdnav_rig rig = small_rig();
  // The bar's other side, its back in the shade, a lit strip before it.
  const std::vector<std::vector<stepped::Step>> surroundings = {
      {{0.0, 110.0}, {6.0, -110.0}}, {{0.0, 110.0}, {4.5, -110.0}}, {{-4.0, -30.0}, {0.0, 110.0}}};
  for (const auto& steps : surroundings) {
    for (int i = 0; i < 4; ++i) {
      const Line2 line = Line2::from_angle(random.real(-10, 10), random.real(-M_PI, M_PI));
      const plain::Grey image = draw(rig, 0, line, {60.0, kLensBlur, steps}, 1.5, random);
      const auto samples = measure(rig, image, edge_along(line, random.real(-0.7, 0.7), -35, 35, 1));
      REQUIRE(samples.size() >= 60);
      CHECK(std::abs(distances(samples, line).mean) < 0.05);
    }
  }
}

TEST_CASE("what lies along the edge of an even face pulls little") {
  plain::Random random(87);
  const rvdnav_rig rig = small_rig();
  // Behind the edge at 0, which lies on the negative side: a gap in the shade, one that grows lighter step by step, a
  // side face lit from the side, a lit strip.
  std::vector<stepped::Step> penumbra = {{-2.4, -12.0}};
  for (double t = -2.2; t <= -0.2; t += 0.2) penumbra.push_back({t, 1.2 - 2.4});
  penumbra.push_back({0.0, 100.0});
  const std::vector<std::vector<stepped::Step>> surroundings = {
      {{-1.5, -12.0}, {0.0, 100.0}}, penumbra, {{-3.0, 14.0}, {0.0, 86.0}}, {{-2.0, -15.0}, {0.0, 100.0}}};
  for (const auto& steps : surroundings) {
    double with = 0.0;
    double without = 0.0;
    for (int i = 0; i < 4; ++i) {
      const Line2 line = Line2::from_angle(random.real(-10, 10), random.real(-M_PI, M_PI));
      const plain::Grey image = draw(rig, 0, line, {70.0, kLensBlur, steps}, 1.0, random);
      const double off = random.real(-0.2, 0.2);
      const auto samples = measure(rig, image, edge_along(line, off, -35, 35, 1, 12.0), {2.5, 1.0, kBlur});
      REQUIRE(samples.size() >= 60);
      CHECK(distances(sloped(samples), line).deviation < 0.06);
      with += distances(sloped(samples), line).mean / 4.0;
      without += distances(samples, line).mean / 4.0;
    }
    CHECK(std::abs(with) < 0.04);
    CHECK(std::abs(with) < std::fmax(0.6 * std::abs(without), 0.02));
  }
}

TEST_CASE("the blur is measured, and then expected") {
  plain::Random random(88);
  const rvdnav_rig rig = small_rig();
  for (const double lens : {0.5, 0.8, 1.1}) {
    for (int i = 0; i < 3; ++i) {
      const Line2 line = Line2::from_angle(random.real(-10, 10), random.real(-M_PI, M_PI));
      // A bar 7 px wide.
      const plain::Grey image = draw(rig, 0, line, {30.0, lens, {{0.0, 120.0}, {7.0, -120.0}}}, 1.5, random);
      double blur = kBlur;
      for (int round = 0; round < 2; ++round) {
        const auto even = measure(rig, image, edge_along(line, 0.1, -35, 35), {2.5, 1.0, blur});
        blur = 0.0;
        for (const rvdnav_edge_sample& sample : even) blur += sample.blur / static_cast<double>(even.size());
      }
      CHECK(blur == doctest::Approx(std::sqrt(lens * lens + 1.0 / 12.0)).epsilon(0.08));
      const auto samples = measure(rig, image, edge_along(line, 0.1, -35, 35, 1, 7.0), {2.5, 1.0, blur});
      REQUIRE(samples.size() >= 60);
      CHECK(std::abs(distances(sloped(samples), line).mean) < 0.03);
    }
  }
}

TEST_CASE("only steps of the wanted polarity are taken") {
  plain::Random random(83);
  const rvdnav_rig rig = small_rig();
  const Line2 line = Line2::from_angle(4.0, 0.3);
  // A bright bar 5 px wide: rising at 0, falling at 5.
  const plain::Grey image = draw(rig, 0, line, {40.0, kLensBlur, {{0.0, 120.0}, {5.0, -120.0}}}, 1.0, random);
  const auto rising = measure(rig, image, edge_along(line, 2.5, -30, 30, 1), {6.0, 1.0, kBlur});
  const auto falling = measure(rig, image, edge_along(line, 2.5, -30, 30, -1), {6.0, 1.0, kBlur});
  REQUIRE(rising.size() >= 58);
  REQUIRE(falling.size() >= 58);
  CHECK(std::abs(distances(rising, line).mean) < 0.05);
  CHECK(std::abs(distances(falling, line).mean - 5.0) < 0.05);
  CHECK(measure(rig, image, edge_along(line, 0.0, -30, 30, -1), {2.5, 1.0, kBlur}).size() <= 2);
}

TEST_CASE("through the lens the step is found where the rectified line runs") {
  plain::Random random(84);
  const rvdnav_rig rig = sample_rig();
  for (int camera = 0; camera < 2; ++camera) {
    for (const double rho : {-210.0, 230.0}) {
      const Line2 line = Line2::from_angle(rho, 0.9);
      const plain::Grey image = draw(rig, camera, line, {40.0, kLensBlur, {{0.0, 120.0}}}, 1.0, random);
      const auto samples = measure(rig, image, edge_along(line, 0.4, -90, 90), kSettings, camera);
      REQUIRE(samples.size() >= 178);
      CHECK(std::abs(distances(samples, line).mean) < 0.03);
      CHECK(distances(samples, line).deviation < 0.1);
    }
  }
}

TEST_CASE("without a step, off the image or too faint there is no sample") {
  plain::Random random(85);
  const rvdnav_rig rig = small_rig();
  const Line2 line = Line2::from_angle(0.0, 1.0);
  const plain::Grey flat = draw(rig, 0, line, {90.0, kLensBlur, {}}, 1.0, random);
  CHECK(measure(rig, flat, edge_along(line, 0.0, -40, 40)).size() <= 4);
  const plain::Grey faint = draw(rig, 0, line, {90.0, kLensBlur, {{0.0, 3.0}}}, 0.3, random);
  CHECK(measure(rig, faint, edge_along(line, 0.0, -40, 40)).empty());
  const plain::Grey good = draw(rig, 0, line, {60.0, kLensBlur, {{0.0, 90.0}}}, 1.0, random);
  CHECK(measure(rig, good, edge_along(line, 0.0, 200, 300)).empty());
  CHECK(measure(rig, good, edge_along(line, 0.0, 1e8, 2e8), {3.5, 1e6, kBlur}).empty());
  CHECK(measure(rig, good, {5.0, 5.0, 5.0, 5.0, 0.0, 0.0, 0, 0}).empty());
  // Half of it off the image: the other half is measured.
  const auto half = measure(rig, good, edge_along(line, 0.0, 0, 120));
  CHECK(half.size() > 40);
  CHECK(half.size() < 100);
}

TEST_CASE("a full array keeps its place and the total tells of the rest") {
  plain::Random random(86);
  const rvdnav_rig rig = small_rig();
  const Line2 line = Line2::from_angle(2.0, 2.0);
  const plain::Grey image = draw(rig, 0, line, {60.0, kLensBlur, {{0.0, 90.0}}}, 1.0, random);
  std::vector<rvdnav_edge_sample> samples(6);
  samples[5].edge = -7;
  const ProfileCount count =
      measure_edge(rig, 0, image.view(), edge_along(line, 0.0, -40, 40), 0, kSettings, samples.data(), 5);
  CHECK(count.found == 80);
  CHECK(count.on_image == 80);
  CHECK(samples[5].edge == -7);
  CHECK(samples[0].fraction < samples[4].fraction);
}

TEST_CASE("both edges of a bar narrower than its blur are measured at once") {
  plain::Random random(89);
  const rvdnav_rig rig = small_rig();
  for (const double lens : {1.5, 2.0, 3.0, 4.0}) {
    const double blur = std::sqrt(lens * lens + 1.0 / 12.0);
    for (const double width : {4.0, 6.0, 8.0}) {
      double together = 0.0;
      double alone = 0.0;
      for (int i = 0; i < 4; ++i) {
        const Line2 line = Line2::from_angle(random.real(-5, 5), random.real(-M_PI, M_PI));
        const plain::Grey image = draw(rig, 0, line, {40.0, lens, {{0.0, 120.0}, {width, -120.0}}}, 1.0, random);
        const ProfileSettings settings = {6.0, 1.0, blur};
        const auto bar = measure(rig, image, edge_along(line, random.real(-0.5, 0.5), -35, 35, 1, width), settings);
        const auto step = measure(rig, image, edge_along(line, 0.0, -35, 35, 1), settings);
        REQUIRE(bar.size() >= 60);
        together += distances(sloped(bar), line).mean / 4.0;
        alone += step.empty() ? 1.0 : distances(step, line).mean / 4.0;
      }
      CHECK(std::abs(together) < 0.05);
      if (width <= 2.4 * blur) CHECK(std::abs(together) < 0.5 * std::abs(alone));
    }
  }
}

TEST_CASE("an edge's own blur takes the place of the call's") {
  plain::Random random(90);
  const rvdnav_rig rig = small_rig();
  const Line2 line = Line2::from_angle(3.0, 0.6);
  const plain::Grey image = draw(rig, 0, line, {40.0, 3.0, {{0.0, 120.0}, {6.0, -120.0}}}, 1.0, random);
  rvdnav_model_edge edge = edge_along(line, 0.2, -35, 35, 1, 6.0);
  const auto expected = measure(rig, image, edge, {6.0, 1.0, 3.0});
  edge.blur = 3.0;
  const auto own = measure(rig, image, edge, {6.0, 1.0, kBlur});
  REQUIRE(own.size() == expected.size());
  REQUIRE(own.size() >= 60);
  for (size_t i = 0; i < own.size(); ++i) CHECK(own[i].offset == expected[i].offset);
}
