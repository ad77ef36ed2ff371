#include <doctest/doctest.h>

#include <cmath>
#include <vector>

#include "lens.hpp"
#include "plain.hpp"
#include "resample.hpp"
#include "sample_rig.hpp"

using namespace rvdnav;

namespace {

struct Rectified {
  rvdnav_rig rig;
  std::vector<int32_t> nodes;
  RectMap map;
  std::vector<int32_t> u, v;
  std::vector<uint16_t> grey;
  std::vector<RowSpan> spans;

  Rectified(const rvdnav_rig& of, int camera)
      : rig(of),
        nodes(rect_map_length(of.width, of.height)),
        map{nodes.data(), 0, 0},
        u(static_cast<size_t>(of.width)),
        v(u.size()),
        grey(u.size() * static_cast<size_t>(of.height)),
        spans(static_cast<size_t>(of.height)) {
    build_rect_map(rig, camera, &map);
  }
  void draw(const plain::Grey& raw) { resample(raw.view(), map, u.data(), v.data(), grey.data(), spans.data()); }
  double at(int32_t i, int32_t j) const { return grey[static_cast<size_t>(j * rig.width + i)] / 256.0; }
};

}  // namespace

TEST_CASE("rows map like the exact lens") {
  for (int camera = 0; camera < 2; ++camera) {
    Rectified r(sample_rig(), camera);
    double worst = 0.0;
    for (int32_t j = 0; j < r.rig.height; ++j) {
      rect_row_to_raw(r.map, j, r.rig.width, r.u.data(), r.v.data());
      for (int32_t i = 0; i < r.rig.width; ++i) {
        double u = 0.0, v = 0.0;
        rect_to_raw(r.rig, camera, i - 0.5 * (r.rig.width - 1), j - 0.5 * (r.rig.height - 1), &u, &v);
        worst = std::fmax(
            worst, std::hypot(r.u[static_cast<size_t>(i)] / 4096.0 - u, r.v[static_cast<size_t>(i)] / 4096.0 - v));
      }
    }
    CHECK(worst < 0.02);
  }
}

TEST_CASE("a smooth picture is resampled where the lens puts it, and spans say where it is") {
  const auto picture = [](double u, double v) { return 120.0 + 60.0 * std::sin(u / 9.0) * std::cos(v / 11.0); };
  Rectified r(sample_rig(), 0);
  plain::Grey raw(r.rig.width, r.rig.height);
  for (int32_t v = 0; v < raw.h; ++v)
    for (int32_t u = 0; u < raw.w; ++u) raw.at(u, v) = static_cast<uint8_t>(std::lround(picture(u, v)));
  r.draw(raw);
  int32_t inside = 0;
  double worst = 0.0;
  for (int32_t j = 0; j < raw.h; ++j) {
    const RowSpan span = r.spans[static_cast<size_t>(j)];
    for (int32_t i = 0; i < raw.w; ++i) {
      double u = 0.0, v = 0.0;
      rect_to_raw(r.rig, 0, i - 0.5 * (raw.w - 1), j - 0.5 * (raw.h - 1), &u, &v);
      const auto within = [&](double margin) {
        return u > margin && v > margin && u < raw.w - 1 - margin && v < raw.h - 1 - margin;
      };
      const bool listed = i >= span.begin && i < span.end;
      if (within(0.05)) CHECK(listed);
      if (!within(-0.05)) CHECK_FALSE(listed);
      if (!within(2.0)) continue;
      ++inside;
      worst = std::fmax(worst, std::abs(r.at(i, j) - picture(u, v)));
    }
  }
  CHECK(inside > 300000);
  CHECK(worst < 1.0);  // rounding to 8 bits gives 0.6
}

TEST_CASE("where the lens looks past the image nothing is listed") {
  rvdnav_rig rig = sample_rig();
  for (double& r : rig.camera[1].R_rect_cam) r = 0.0;
  // Turned by 150 degrees about y: the rectified view is behind the camera.
  const double c = std::cos(2.618), s = std::sin(2.618);
  rig.camera[1].R_rect_cam[0] = rig.camera[1].R_rect_cam[8] = c;
  rig.camera[1].R_rect_cam[4] = 1.0;
  rig.camera[1].R_rect_cam[2] = s;
  rig.camera[1].R_rect_cam[6] = -s;
  rig.camera[1].cx = -3000.0;
  Rectified r(rig, 1);
  r.draw(plain::Grey(rig.width, rig.height, 77));
  for (const RowSpan& span : r.spans) CHECK(span.begin == span.end);
  for (const uint16_t grey : r.grey) REQUIRE(grey == 77 * 256);
}
