#include <doctest/doctest.h>

#include <vector>

#include "kernels/kernels.hpp"
#include "plain.hpp"
#include "rvdnav/rvdnav.h"

using namespace rvdnav;

namespace {

// Everything the kernels give for one set of rows.
struct Rows {
  std::vector<uint8_t> smoothed, sector, candidate;
  std::vector<int16_t> magnitude;
};

Rows run(const Kernels& kernels, const plain::Grey& image, const std::vector<int16_t>& ridge, int16_t minimum) {
  const auto w = static_cast<size_t>(image.w);
  const uint8_t* p = image.pixels.data();
  Rows rows{std::vector<uint8_t>(w), std::vector<uint8_t>(w, 9), std::vector<uint8_t>(w, 9),
            std::vector<int16_t>(w, -1)};
  std::vector<uint16_t> scratch(w + 2);
  kernels.smooth_row(p, p + w, p + 2 * w, image.w, scratch.data(), rows.smoothed.data());
  kernels.gradient_row(p, p + w, p + 2 * w, image.w, rows.magnitude.data(), rows.sector.data());
  kernels.ridge_row(&ridge[0], &ridge[w], &ridge[2 * w], rows.sector.data(), image.w, minimum, rows.candidate.data());
  return rows;
}

}  // namespace

TEST_CASE("every instruction set that this build and machine have gives the bits of the scalar kernels") {
  const Kernels* scalar = select_kernels(RVDNAV_ISA_SCALAR);
  REQUIRE(scalar != nullptr);
  plain::Random random(2);
  for (int32_t isa : {RVDNAV_ISA_AVX2, RVDNAV_ISA_NEON}) {
    const Kernels* kernels = select_kernels(isa);
    if (kernels == nullptr) continue;
    CHECK(kernels->isa == isa);
    for (int32_t w = 5; w < 200; ++w) {
      // Extremes as well as everything between; ridges with many equal values.
      const plain::Grey image = w % 2 != 0 ? plain::random_grey(random, w, 3) : plain::random_grey(random, w, 3, 0, 1);
      plain::Grey wide = image;
      if (w % 2 == 0)
        for (uint8_t& v : wide.pixels) v = static_cast<uint8_t>(v * 255);
      std::vector<int16_t> ridge(static_cast<size_t>(3 * w));
      for (int16_t& m : ridge) m = static_cast<int16_t>(random.between(0, w % 3 == 0 ? 1020 : 3));
      const int16_t minimum = static_cast<int16_t>(random.between(1, 3));
      const Rows a = run(*scalar, wide, ridge, minimum), b = run(*kernels, wide, ridge, minimum);
      REQUIRE(a.smoothed == b.smoothed);
      REQUIRE(a.magnitude == b.magnitude);
      REQUIRE(a.sector == b.sector);
      REQUIRE(a.candidate == b.candidate);
    }
  }
}

TEST_CASE("the automatic choice is one of the sets there are") {
  const Kernels* best = select_kernels(RVDNAV_ISA_AUTO);
  REQUIRE(best != nullptr);
  CHECK(select_kernels(best->isa) == best);
  CHECK(select_kernels(99) == nullptr);
#if defined(__x86_64__)
  CHECK(select_kernels(RVDNAV_ISA_NEON) == nullptr);
  if (__builtin_cpu_supports("avx2")) CHECK(best->isa == RVDNAV_ISA_AVX2);
#endif
}
