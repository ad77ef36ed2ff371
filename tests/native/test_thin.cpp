#include <doctest/doctest.h>

#include <set>

#include "plain.hpp"
#include "rvdnav/rvdnav.h"
#include "thin.hpp"

using namespace rvdnav;

namespace {

plain::BitImage filtered(plain::BitImage bits, int32_t min_run) {
  std::vector<uint32_t> kept(bits.words.size(), 0xa5a5a5a5u);
  filter_edges(bits.words.data(), bits.w, bits.h, min_run, *select_kernels(RVDNAV_ISA_AUTO), kept.data());
  return bits;
}

plain::BitImage thinned(plain::BitImage bits) {
  std::vector<uint32_t> deletable(static_cast<size_t>(edge_row_words(bits.w))), empty(deletable.size(), 0xa5a5a5a5u);
  std::vector<uint8_t> stale(static_cast<size_t>(bits.h));
  thin(bits.words.data(), bits.w, bits.h, *select_kernels(RVDNAV_ISA_AUTO),
       {deletable.data(), empty.data(), stale.data()});
  return bits;
}

plain::BitImage discs_and_bars(plain::Random& random, int32_t w, int32_t h) {
  plain::BitImage bits(w, h);
  for (int n = 0; n < 6; ++n) {
    const int32_t cx = random.between(0, w - 1), cy = random.between(0, h - 1), r = random.between(1, 9);
    const bool ring = random.between(0, 1) != 0;
    for (int32_t y = 0; y < h; ++y)
      for (int32_t x = 0; x < w; ++x) {
        const int32_t d2 = (x - cx) * (x - cx) + (y - cy) * (y - cy);
        if (d2 <= r * r && (!ring || d2 >= r * r / 3)) bits.put(x, y, true);
      }
  }
  return bits;
}

// Simple, by its definition: in the 3x3 block without its centre, one 8-connected piece of edge, and one 4-connected
// piece of background that touches a side.
bool simple(const plain::BitImage& bits, int32_t x, int32_t y) {
  plain::BitImage ring(3, 3), ground(3, 3);
  for (int32_t v = 0; v < 3; ++v)
    for (int32_t u = 0; u < 3; ++u) {
      const bool centre = u == 1 && v == 1;
      const bool set = bits.get(x + u - 1, y + v - 1);
      ring.put(u, v, set && !centre);
      ground.put(u, v, !set && !centre);
    }
  int touching = 0;
  for (const plain::Component& piece : plain::components(ground, true, false)) {
    const std::set<std::pair<int32_t, int32_t>> pixels(piece.begin(), piece.end());
    touching += pixels.count({1, 0}) + pixels.count({0, 1}) + pixels.count({2, 1}) + pixels.count({1, 2}) > 0 ? 1 : 0;
  }
  return plain::components(ring, true, true).size() == 1 && touching == 1;
}

int32_t neighbour_count(const plain::BitImage& bits, int32_t x, int32_t y) {
  int32_t n = 0;
  for (int32_t dy = -1; dy <= 1; ++dy)
    for (int32_t dx = -1; dx <= 1; ++dx) n += (dx != 0 || dy != 0) && bits.get(x + dx, y + dy) ? 1 : 0;
  return n;
}

void check_thin(const plain::BitImage& before) {
  const plain::BitImage after = thinned(before);
  for (size_t i = 0; i < before.words.size(); ++i) REQUIRE((after.words[i] & ~before.words[i]) == 0);
  REQUIRE(plain::components(after, true, true).size() == plain::components(before, true, true).size());
  REQUIRE(plain::components(after, false, false).size() == plain::components(before, false, false).size());
  for (int32_t y = 0; y < after.h; ++y)
    for (int32_t x = 0; x < after.w; ++x)
      if (after.get(x, y)) REQUIRE(!(simple(after, x, y) && neighbour_count(after, x, y) >= 2));
  REQUIRE(thinned(after) == after);
}

}  // namespace

TEST_CASE("filter_edges removes the components with fewer pixels than asked for, and nothing else") {
  plain::Random random(5);
  for (int i = 0; i < 80; ++i) {
    const int32_t w = random.between(1, 100), h = random.between(1, 40), min_run = random.between(0, 20);
    const plain::BitImage bits = plain::random_bits(random, w, h, random.between(2, 45));
    plain::BitImage expected = bits;
    for (const plain::Component& component : plain::components(bits, true, true))
      if (static_cast<int32_t>(component.size()) < min_run)
        for (const auto& [x, y] : component) expected.put(x, y, false);
    REQUIRE(filtered(bits, min_run) == expected);
  }
}

TEST_CASE("filter_edges at its longest run") {
  plain::BitImage bits(80, 5);
  for (int32_t x = 0; x < kMaxMinRun - 1; ++x) bits.put(x, 0, true);
  for (int32_t x = 0; x < kMaxMinRun; ++x) bits.put(x, 4, true);
  const plain::BitImage kept = filtered(bits, kMaxMinRun);
  CHECK(kept.count() == kMaxMinRun);
  CHECK(kept.get(0, 4));
}

TEST_CASE("thinning keeps components and holes and leaves no deletable pixel") {
  plain::Random random(6);
  for (int i = 0; i < 60; ++i) {
    const int32_t w = random.between(1, 75), h = random.between(1, 30);
    check_thin(plain::random_bits(random, w, h, random.between(5, 95)));
    check_thin(discs_and_bars(random, random.between(30, 75), random.between(20, 50)));
  }
}

TEST_CASE("a thick bar becomes its middle line, a thin one stays") {
  plain::BitImage thick(60, 20), line(60, 20);
  for (int32_t x = 5; x < 55; ++x) {
    line.put(x, 10, true);
    for (int32_t y = 8; y <= 12; ++y) thick.put(x, y, true);
  }
  CHECK(thinned(line) == line);
  const plain::BitImage middle = thinned(thick);
  for (int32_t x = 10; x < 50; ++x) {
    int32_t pixels = 0;
    for (int32_t y = 0; y < 20; ++y) pixels += middle.get(x, y) ? 1 : 0;
    CHECK(pixels == 1);
    CHECK((middle.get(x, 9) || middle.get(x, 10) || middle.get(x, 11)));
  }
}
