#include <doctest/doctest.h>

#include <cmath>
#include <functional>
#include <memory>
#include <vector>

#include "epipolar.hpp"
#include "plain.hpp"
#include "sample_rig.hpp"
#include "scene.hpp"
#include "stepped_images.hpp"

using namespace rvdnav;

namespace {

using Texture = std::function<double(double x, double y)>;

// Waves of many directions, four to ten pixels long: smooth, and nowhere like itself.
Texture waves(uint64_t seed) {
  struct Wave {
    double kx, ky, phase;
  };
  plain::Random random(seed);
  std::vector<Wave> all;
  for (int i = 0; i < 40; ++i) {
    const double length = random.real(4.0, 10.0), angle = random.real(0.0, M_PI);
    all.push_back(
        {2.0 * M_PI / length * std::cos(angle), 2.0 * M_PI / length * std::sin(angle), random.real(-M_PI, M_PI)});
  }
  return [all](double x, double y) {
    double sum = 0.0;
    for (const Wave& w : all) sum += std::sin(w.kx * x + w.ky * y + w.phase);
    return 110.0 + 9.0 * sum;
  };
}

// A band of rows around the row of the optical axis; all that the search at y = 0 may touch.
plain::Grey draw(const rvdnav_rig& rig, int camera, const Texture& texture, double noise, uint64_t seed) {
  plain::Random random(seed);
  plain::Grey image(rig.width, rig.height, 100);
  for (int v = rig.height / 2 - 40; v < rig.height / 2 + 40; ++v) {
    for (int u = 0; u < rig.width; ++u) {
      double x = 0.0, y = 0.0;
      raw_to_rect(rig, camera, u, v, &x, &y);
      const double grey = std::round(texture(x, y) + noise * stepped::normal(random));
      image.at(u, v) = static_cast<uint8_t>(std::fmin(std::fmax(grey, 0.0), 255.0));
    }
  }
  return image;
}

// The texture of the left view as the right one sees it, x_left = x_right + disparity(y).
plain::Grey draw_right(const rvdnav_rig& rig, const Texture& texture, const std::function<double(double)>& disparity,
                       double noise, uint64_t seed, double rows_down = 0.0) {
  return draw(
      rig, 1, [&](double x, double y) { return texture(x + disparity(y - rows_down), y - rows_down); }, noise, seed);
}

std::vector<rvdnav_match> correlate(const rvdnav_config& config, const rvdnav_rig& rig, const plain::Grey& left,
                                    const plain::Grey& right, std::vector<rvdnav_match> matches) {
  const Disparities disparities = allowed_disparities(config, rig, 600.0);
  std::vector<int16_t> window(kMaxWindow * kMaxWindow);
  std::vector<int16_t> band(static_cast<size_t>((disparities.count + kMaxWindow) * kMaxBandRows));
  std::vector<float> score(static_cast<size_t>(disparities.count));
  const MatchScratch scratch = {window.data(), band.data(), score.data()};
  correlate_rows(config, rig, disparities, left.view(), right.view(), scratch, matches.data(),
                 static_cast<uint32_t>(matches.size()));
  return matches;
}

rvdnav_match point(double x, double y, int32_t bar = 0) {
  rvdnav_match m = {};
  m.x = x;
  m.y = y;
  m.bar = bar;
  return m;
}

std::vector<rvdnav_match> points(plain::Random& random, int n, double low, double high) {
  std::vector<rvdnav_match> out;
  for (int i = 0; i < n; ++i) out.push_back(point(random.real(low, high), random.real(-20.0, 20.0), -1 + i % 5));
  return out;
}

// Nothing but the score, and not much of it.
rvdnav_config lenient() {
  rvdnav_config c = scene::config();
  c.match_min_score_q8 = 100;
  c.match_uniqueness_q8 = 256;
  c.match_consistency_q8 = 1 << 16;
  c.match_max_gradient_q8 = 1 << 16;
  return c;
}

}  // namespace

TEST_CASE("textured points get their disparity to a tenth of a pixel") {
  const rvdnav_config config = scene::config();
  plain::Random random(100);
  for (const bool squinting : {false, true}) {
    const rvdnav_rig rig = squinting ? sample_rig() : scene::rig();
    const Texture texture = waves(1);
    const plain::Grey left = draw(rig, 0, texture, 2.0, 2);
    for (const double disparity : {52.0, 96.5, 180.27}) {
      const plain::Grey right = draw_right(
          rig, texture, [=](double) { return disparity; }, 2.0, 3);
      double sum = 0.0;
      int accepted = 0;
      for (const rvdnav_match& m : correlate(config, rig, left, right, points(random, 30, -80.0, 250.0))) {
        accepted += m.accepted;
        if (m.accepted == 0) continue;
        CHECK(std::abs(m.disparity - disparity) < 0.1);
        CHECK(m.score > 0.85);
        CHECK(m.score <= 1.0 + 1e-9);
        sum += m.disparity - disparity;
      }
      CHECK(accepted >= 27);
      CHECK(std::abs(sum / accepted) < 0.03);
    }
  }
}

TEST_CASE("windows on a slanted face keep their place") {
  const rvdnav_config config = scene::config();
  const rvdnav_rig rig = scene::rig();
  const Texture texture = waves(4);
  const auto disparity = [](double y) { return 100.0 + 0.1 * y; };
  const plain::Grey left = draw(rig, 0, texture, 1.0, 5);
  const plain::Grey right = draw_right(rig, texture, disparity, 1.0, 6);
  plain::Random random(101);
  int accepted = 0;
  for (const rvdnav_match& m : correlate(config, rig, left, right, points(random, 30, -80.0, 250.0))) {
    accepted += m.accepted;
    if (m.accepted != 0) CHECK(std::abs(m.disparity - disparity(m.y)) < 0.3);
  }
  CHECK(accepted >= 25);
}

TEST_CASE("a brighter or flatter right view matches as well, noise does not") {
  const rvdnav_config config = scene::config();
  const rvdnav_rig rig = scene::rig();
  const Texture texture = waves(7);
  const plain::Grey left = draw(rig, 0, texture, 1.0, 8);
  const plain::Grey dim = draw(
      rig, 1, [&](double x, double y) { return 60.0 + 0.4 * texture(x + 120.0, y); }, 0.5, 9);
  for (const rvdnav_match& m : correlate(config, rig, left, dim, {point(20, 3), point(60, -7)})) {
    CHECK(m.accepted == 1);
    CHECK(m.disparity == doctest::Approx(120.0).epsilon(0.001));
  }
  const plain::Grey other = draw(
      rig, 1, [](double, double) { return 110.0; }, 25.0, 11);
  plain::Random random(102);
  for (const rvdnav_match& m : correlate(config, rig, left, other, points(random, 20, -50, 200)))
    CHECK(m.accepted == 0);
}

TEST_CASE("rows may differ by the tolerance and no more") {
  rvdnav_config config = scene::config();
  const rvdnav_rig rig = scene::rig();
  // Fine detail across the rows.
  const Texture texture = [base = waves(12)](double x, double y) { return base(x, 3.0 * y); };
  const plain::Grey left = draw(rig, 0, texture, 1.0, 13);
  for (const int rows : {1, 3}) {
    const plain::Grey right = draw_right(
        rig, texture, [](double) { return 90.0; }, 1.0, 14, rows);
    for (const int tolerance : {0, 1, 3}) {
      config.match_row_tolerance = tolerance;
      const rvdnav_match m = correlate(config, rig, left, right, {point(30.0, 2.0)})[0];
      CHECK(m.accepted == (tolerance >= rows ? 1 : 0));
      if (m.accepted != 0) CHECK(m.disparity == doctest::Approx(90.0).epsilon(0.002));
    }
  }
}

TEST_CASE("disparities outside the range gate are not looked at") {
  rvdnav_config config = scene::config();
  const rvdnav_rig rig = scene::rig();
  const Texture texture = waves(15);
  const plain::Grey left = draw(rig, 0, texture, 1.0, 16);
  const plain::Grey right = draw_right(
      rig, texture, [](double) { return 100.0; }, 1.0, 17);  // 0.804 m
  config.match_min_score_q8 = 230;                           // no likeness by chance
  for (const double range : {0.7, 0.9}) {
    config.range_min = range < 0.8 ? 0.25 : range;
    config.range_max = range < 0.8 ? range : 1.7;
    CHECK(correlate(config, rig, left, right, {point(0, 0)})[0].accepted == 0);
  }
  config.range_min = 0.7;
  config.range_max = 0.9;
  CHECK(correlate(config, rig, left, right, {point(0, 0)})[0].accepted == 1);
}

TEST_CASE("without structure or off the image nothing matches") {
  const rvdnav_rig rig = scene::rig();
  const plain::Grey flat(rig.width, rig.height, 90);
  const Texture texture = waves(18);
  const plain::Grey left = draw(rig, 0, texture, 1.0, 19);
  const plain::Grey right = draw_right(
      rig, texture, [](double) { return 80.0; }, 1.0, 20);
  CHECK(correlate(lenient(), rig, flat, right, {point(0, 0)})[0].accepted == 0);
  CHECK(correlate(lenient(), rig, left, flat, {point(0, 0)})[0].accepted == 0);
  for (const rvdnav_match& m :
       correlate(lenient(), rig, left, right, {point(349, 0), point(-349, 0), point(0, 9000), point(-9000, 0)})) {
    CHECK(m.accepted == 0);
  }
}

TEST_CASE("a repeated pattern is rejected for its rivals") {
  const rvdnav_rig rig = scene::rig();
  const Texture stripes = [](double x, double y) {
    return 110.0 + 60.0 * std::sin(2.0 * M_PI * x / 18.0) + 30.0 * std::sin(0.3 * y);
  };
  const plain::Grey left = draw(rig, 0, stripes, 1.0, 21);
  const plain::Grey right = draw_right(
      rig, stripes, [](double) { return 90.0; }, 1.0, 22);
  CHECK(correlate(lenient(), rig, left, right, {point(10, 0)})[0].accepted == 1);
  rvdnav_config config = lenient();
  config.match_uniqueness_q8 = scene::config().match_uniqueness_q8;
  CHECK(correlate(config, rig, left, right, {point(10, 0)})[0].accepted == 0);
}

TEST_CASE("a point that the right view gives back to another is rejected") {
  const rvdnav_rig rig = scene::rig();
  const Texture ground = waves(23), patch = waves(24), other = waves(25);
  // The left view holds the patch about x = 100, and a poorer copy about x = 10; the right view holds it once.
  const auto near = [](double x, double middle) { return std::abs(x - middle) < 14.0; };
  const plain::Grey left = draw(
      rig, 0,
      [&](double x, double y) {
        if (near(x, 100.0)) return patch(x - 100.0, y);
        return near(x, 10.0) ? 0.75 * patch(x - 10.0, y) + 0.25 * other(x, y) : ground(x, y);
      },
      1.0, 26);
  const plain::Grey right = draw(
      rig, 1, [&](double x, double y) { return near(x, -50.0) ? patch(x + 50.0, y) : other(x + 30.0, y); }, 1.0, 27);
  const std::vector<rvdnav_match> asked = {point(10, 0), point(100, 0)};
  const auto loose = correlate(lenient(), rig, left, right, asked);
  CHECK(loose[0].accepted == 1);
  CHECK(loose[0].disparity == doctest::Approx(60.0).epsilon(0.01));
  rvdnav_config config = lenient();
  config.match_consistency_q8 = scene::config().match_consistency_q8;
  const auto strict = correlate(config, rig, left, right, asked);
  CHECK(strict[0].accepted == 0);
  CHECK(strict[1].accepted == 1);
  CHECK(strict[1].disparity == doctest::Approx(150.0).epsilon(0.002));
}

TEST_CASE("of neighbours on a bar with a steep disparity the poorer one goes") {
  const rvdnav_rig rig = scene::rig();
  const Texture texture = waves(28);
  const plain::Grey left = draw(rig, 0, texture, 1.0, 29);
  plain::Grey right = draw_right(
      rig, texture, [](double y) { return y < 0.0 ? 60.0 : 110.0; }, 1.0, 30);
  // The lower half is the noisier one.
  plain::Random random(103);
  for (int v = rig.height / 2; v < rig.height / 2 + 40; ++v) {
    for (int u = 0; u < rig.width; ++u) right.at(u, v) = static_cast<uint8_t>(right.at(u, v) + random.between(-8, 8));
  }
  rvdnav_config config = lenient();
  config.match_max_gradient_q8 = scene::config().match_max_gradient_q8;
  const auto same_bar = correlate(config, rig, left, right, {point(40, -8, 2), point(40, 8, 2)});
  CHECK(same_bar[0].accepted == 1);
  CHECK(same_bar[1].accepted == 0);
  CHECK(same_bar[1].disparity == doctest::Approx(110.0).epsilon(0.01));
  for (const rvdnav_match& m : correlate(config, rig, left, right, {point(40, -8, 2), point(40, 8, 3)}))
    CHECK(m.accepted == 1);
  for (const rvdnav_match& m : correlate(lenient(), rig, left, right, {point(40, -8, 2), point(40, 8, 2)}))
    CHECK(m.accepted == 1);
}
