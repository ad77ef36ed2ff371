#include <doctest/doctest.h>

#include <algorithm>
#include <vector>

#include "edge.hpp"
#include "hough.hpp"
#include "kernels/kernels.hpp"
#include "plain.hpp"
#include "rvdnav/rvdnav.h"
#include "sample_rig.hpp"

using namespace rvdnav;

namespace {

// Everything the kernels give for one set of rows.
struct Rows {
  std::vector<uint8_t> smoothed, code;
  std::vector<int16_t> magnitude;
  std::vector<uint32_t> ridge, north_west, south_east, kept;
  uint64_t sum = 0;
  uint32_t bright = 0;
};

// Three rows of each kind of input.
struct Input {
  plain::Grey image;
  ThresholdCurve threshold;
  std::vector<int16_t> ridge;    // with margins
  std::vector<uint8_t> code;     // one row
  std::vector<uint32_t> pixels;  // packed

  Input(plain::Random& random, int32_t w)
      : image(plain::random_grey(random, w, 3, 0, w % 3 == 0 ? 1 : 255)),
        threshold(make_threshold_curve(random.between(0, 30), random.between(0, 255), random.between(0, 255))) {
    // Extremes as well as everything between; ridges with many equal values.
    if (w % 3 == 0)
      for (uint8_t& v : image.pixels) v = static_cast<uint8_t>(v * 255);
    ridge.resize(3 * edge_scratch_row(static_cast<size_t>(w)));
    for (int16_t& m : ridge) m = static_cast<int16_t>(random.between(0, w % 2 == 0 ? 1020 : 3));
    code.resize(edge_scratch_row(static_cast<size_t>(w)));
    for (size_t x = 1; x + 1 < static_cast<size_t>(w); ++x) code[x] = static_cast<uint8_t>(random.between(0, 4));
    pixels = plain::random_bits(random, w, 3, random.between(5, 95)).words;
  }
};

Rows run(const Kernels& kernels, const Input& in) {
  const auto w = static_cast<size_t>(in.image.w), words = in.pixels.size() / 3;
  const uint8_t* p = in.image.pixels.data();
  Rows rows;
  rows.smoothed.resize(w);
  rows.code.resize(w, 9);
  rows.magnitude.resize(w, -1);
  for (auto* bits : {&rows.ridge, &rows.north_west, &rows.south_east}) bits->resize(words, 9);
  std::vector<uint16_t> scratch(w + 2);
  kernels.smooth_row(p, p + w, p + 2 * w, in.image.w, scratch.data(), rows.smoothed.data());
  kernels.gradient_row(p, p + w, p + 2 * w, in.image.w, in.threshold, rows.magnitude.data(), rows.code.data());
  const int16_t* ridge = in.ridge.data() + kRowMargin;
  const size_t stride = in.ridge.size() / 3;
  kernels.ridge_row(ridge, ridge + stride, ridge + 2 * stride, in.code.data(), in.image.w, rows.ridge.data());
  const uint32_t* q = in.pixels.data();
  for (const Borders borders : {Borders::kNorthWest, Borders::kSouthEast}) {
    std::vector<uint32_t>& found = borders == Borders::kNorthWest ? rows.north_west : rows.south_east;
    const bool any =
        kernels.deletable_row(q, q + words, q + 2 * words, static_cast<int32_t>(words), borders, found.data());
    CHECK(any == (std::count(found.begin(), found.end(), 0u) != static_cast<ptrdiff_t>(words)));
  }
  rows.kept.resize(words);
  kernels.touching_row(q + words, q, static_cast<int32_t>(words), rows.kept.data());
  kernels.light_row(p, in.image.w, 250, &rows.sum, &rows.bright);
  return rows;
}

}  // namespace

TEST_CASE("every instruction set that this build and machine have gives the bits of the scalar kernels") {
  const Kernels* scalar = select_kernels(RVDNAV_ISA_SCALAR);
  REQUIRE(scalar != nullptr);
  plain::Random random(2);
  for (int32_t isa : {RVDNAV_ISA_SSE2, RVDNAV_ISA_AVX2, RVDNAV_ISA_NEON}) {
    const Kernels* kernels = select_kernels(isa);
    if (kernels == nullptr) continue;
    CHECK(kernels->isa == isa);
    for (int32_t w = 5; w < 700; w += w < 200 ? 1 : 13) {
      const Input input(random, w);
      const Rows a = run(*scalar, input), b = run(*kernels, input);
      REQUIRE(a.smoothed == b.smoothed);
      REQUIRE(a.magnitude == b.magnitude);
      REQUIRE(a.code == b.code);
      REQUIRE(a.ridge == b.ridge);
      REQUIRE(a.north_west == b.north_west);
      REQUIRE(a.south_east == b.south_east);
      REQUIRE(a.kept == b.kept);
      REQUIRE(a.sum == b.sum);
      REQUIRE(a.bright == b.bright);
    }
  }
}

TEST_CASE("every instruction set gives single edge pixels the same directions, edgels and votes") {
  const Kernels& scalar = *select_kernels(RVDNAV_ISA_SCALAR);
  const Kernels& kernels = *select_kernels(RVDNAV_ISA_AUTO);
  plain::Random random(3);
  rvdnav_rig rig = sample_rig();
  std::vector<int16_t> nodes(map_length(rig.width, rig.height));
  const plain::Grey image = plain::random_grey(random, rig.width, rig.height);
  // A lens of everyday's, one with places without a ray, and one whose tangents are beyond all reason.
  for (int lens = 0; lens < 3; ++lens) {
    LensMap map;
    if (lens == 1) rig.camera[0].k1 = -0.9;
    REQUIRE(build_lens_map(rig, 0, nodes.data(), &map));
    CHECK(map.complete == (lens != 1));
    if (lens == 2) {
      for (int16_t& n : nodes) n = static_cast<int16_t>(random.between(-32767, 32767));
      map.shift = 3;
    }
    for (int32_t count : {1, 7, 8, 93, kPixelBatch}) {
      std::vector<uint32_t> pixels(static_cast<size_t>(kPixelBatch));
      for (uint32_t& p : pixels) p = packed_pixel(random.between(2, rig.width - 3), random.between(2, rig.height - 3));
      std::vector<uint8_t> a(pixels.size()), b(pixels.size());
      scalar.gradient_levels(image.pixels.data(), rig.width, pixels.data(), count, a.data());
      kernels.gradient_levels(image.pixels.data(), rig.width, pixels.data(), count, b.data());
      REQUIRE(std::equal(a.begin(), a.begin() + count, b.begin()));
      std::vector<rvdnav_edgel> c(pixels.size()), d(pixels.size());
      const int32_t found = scalar.rectify_pixels(map, pixels.data(), a.data(), count, c.data());
      REQUIRE(kernels.rectify_pixels(map, pixels.data(), a.data(), count, d.data()) == found);
      for (size_t i = 0; i < static_cast<size_t>(found); ++i) {
        REQUIRE(c[i].x_q5 == d[i].x_q5);
        REQUIRE(c[i].y_q5 == d[i].y_q5);
        REQUIRE(c[i].direction == d[i].direction);
      }
    }
    rig = sample_rig();
  }
  for (int i = 0; i < 2000; ++i) {
    std::vector<uint16_t> cells(36);
    for (uint16_t& c : cells) c = static_cast<uint16_t>(random.between(0, i % 3 == 0 ? 65535 : i % 3 == 1 ? 100 : 3));
    const auto least = static_cast<uint16_t>(random.between(0, i % 3 == 0 ? 65535 : 200));
    REQUIRE(scalar.high_cells(&cells[2], least) == kernels.high_cells(&cells[2], least));
  }
  for (int32_t rho_bins : {1, 100, 1024, 1523}) {
    std::vector<rvdnav_edgel> edgels;
    for (int32_t i = 0; i < 500; ++i) {
      const int32_t reach = i % 3 == 0 ? INT32_MAX : i % 3 == 1 ? 66000 : 12000;
      edgels.push_back({random.between(-reach / 2, reach / 2) * 2,
                        random.between(-reach / 2, reach / 2) * 2,
                        static_cast<uint8_t>(random.between(0, 255)),
                        {}});
    }
    for (int32_t spread : {0, 3, 4, 20, 45}) {
      std::vector<uint16_t> a(static_cast<size_t>(kThetaBins * rho_bins)), b(a.size());
      scalar.vote(edgels.data(), 500, rho_bins, spread, a.data());
      kernels.vote(edgels.data(), 500, rho_bins, spread, b.data());
      REQUIRE(a == b);
    }
  }
}

TEST_CASE("every ratio of a gradient's components has the same direction with every instruction set") {
  plain::Grey image(4 * 128 + 4, 5);
  std::vector<uint32_t> pixels;
  for (int32_t i = 0; i < 128; ++i) {  // (254, 2 i)
    const int32_t x = 4 * i + 2;
    image.at(x + 1, 2) = 127;
    image.at(x, 3) = static_cast<uint8_t>(i);
    pixels.push_back(packed_pixel(x, 2));
  }
  std::vector<uint8_t> a(pixels.size()), b(pixels.size());
  select_kernels(RVDNAV_ISA_SCALAR)->gradient_levels(image.pixels.data(), image.w, pixels.data(), 128, a.data());
  select_kernels(RVDNAV_ISA_AUTO)->gradient_levels(image.pixels.data(), image.w, pixels.data(), 128, b.data());
  CHECK(a == b);
  CHECK(a.back() == 32);
}

TEST_CASE("the automatic choice is one of the sets there are") {
  const Kernels* best = select_kernels(RVDNAV_ISA_AUTO);
  REQUIRE(best != nullptr);
  CHECK(select_kernels(best->isa) == best);
  CHECK(select_kernels(99) == nullptr);
#if defined(__x86_64__)
  CHECK(select_kernels(RVDNAV_ISA_NEON) == nullptr);
  CHECK(best->isa == (__builtin_cpu_supports("avx2") ? RVDNAV_ISA_AVX2 : RVDNAV_ISA_SSE2));
  CHECK(select_kernels(RVDNAV_ISA_SSE2)->isa == RVDNAV_ISA_SSE2);
#endif
}
