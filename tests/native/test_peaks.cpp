#include <doctest/doctest.h>

#include <algorithm>
#include <cmath>
#include <vector>

#include "edgel_lines.hpp"
#include "hough.hpp"
#include "parabola.hpp"
#include "peak_list.hpp"
#include "peaks.hpp"

using namespace rvdnav;

namespace {

constexpr int32_t kRhoBins = 1024;

std::vector<rvdnav_peak> peaks_of(const std::vector<uint16_t>& acc, int32_t rho_bins, int32_t min_votes,
                                  uint32_t capacity = 4096, uint32_t* total = nullptr) {
  std::vector<rvdnav_peak> peaks(capacity);
  uint32_t all = 0;
  peaks.resize(
      hough_peaks(acc.data(), rho_bins, min_votes, *select_kernels(RVDNAV_ISA_AUTO), peaks.data(), capacity, &all));
  if (total != nullptr) *total = all;
  return peaks;
}

std::vector<rvdnav_peak> peaks_of_lines(const std::vector<plain::Line>& lines, int clutter, int32_t min_votes) {
  plain::Random random(10);
  std::vector<rvdnav_edgel> edgels;
  for (const plain::Line& line : lines) plain::add_line(edgels, line, random);
  plain::add_clutter(edgels, clutter, random);
  std::vector<uint16_t> acc(static_cast<size_t>(kThetaBins * kRhoBins));
  hough_vote(edgels.data(), static_cast<uint32_t>(edgels.size()), kRhoBins, 4, *select_kernels(RVDNAV_ISA_AUTO),
             acc.data());
  return peaks_of(acc, kRhoBins, min_votes);
}

double nearest(const std::vector<rvdnav_peak>& peaks, const plain::Line& line) {
  double best = 1e9;
  for (const rvdnav_peak& p : peaks)
    best = std::fmin(best, plain::distance_at_ends(line, plain::rho_of(p), plain::theta_of(p)));
  return best;
}

// The suppression by its definition, on an accumulator unrolled three times over theta.
std::vector<std::pair<int32_t, int32_t>> plain_peaks(const std::vector<uint16_t>& acc, int32_t n, int32_t min_votes) {
  const auto raw = [&](int32_t row, int32_t rho) -> int32_t {
    if (rho < 0 || rho >= n) return 0;
    return acc[static_cast<size_t>(row * n + rho)];
  };
  const auto value = [&](int32_t row, int32_t rho) {
    return raw(row, rho - 1) + 2 * raw(row, rho) + raw(row, rho + 1);
  };
  std::vector<std::pair<int32_t, int32_t>> found;
  for (int32_t row = 0; row < 180; ++row)
    for (int32_t rho = 1; rho < n - 1; ++rho) {
      const int32_t v = value(row, rho);
      bool best = v > 0 && v >= 2 * min_votes;
      for (int32_t dr = -3; dr <= 3 && best; ++dr)
        for (int32_t dc = -2; dc <= 2 && best; ++dc) {
          int32_t r = row + dr, c = rho + dc;
          if (r < 0 || r >= 180) {
            r = (r + 180) % 180;
            c = n / 2 - (c - n / 2);
          }
          const int32_t o = value(r, c);
          if (o > v || (o == v && std::make_pair(r, c) < std::make_pair(row, rho))) best = false;
        }
      if (best) found.emplace_back(row, rho);
    }
  return found;
}

}  // namespace

TEST_CASE("peaks are the local maxima by definition, across the wrap as well") {
  plain::Random random(11);
  for (int i = 0; i < 12; ++i) {
    const int32_t n = random.between(64, 70);
    std::vector<uint16_t> acc(static_cast<size_t>(180 * n));
    for (uint16_t& a : acc) a = static_cast<uint16_t>(random.between(0, 9) == 0 ? random.between(0, 6) : 0);
    const std::vector<std::pair<int32_t, int32_t>> expected = plain_peaks(acc, n, 3);
    const std::vector<rvdnav_peak> peaks = peaks_of(acc, n, 3);
    REQUIRE(peaks.size() == expected.size());
    for (const auto& [row, rho] : expected) {
      const bool there = std::any_of(peaks.begin(), peaks.end(), [&](const rvdnav_peak& p) {
        const double turn = p.theta_q8 / 256.0 - (row - 45.0);
        const bool flipped = std::fabs(turn) > 90.0;
        return std::fabs(std::remainder(turn, 180.0)) <= 0.5 &&
               std::fabs((flipped ? -1 : 1) * p.rho_q8 / 256.0 - (rho - n / 2)) <= 0.5;
      });
      REQUIRE(there);
    }
  }
}

TEST_CASE("lines of any direction are found within a pixel at their ends") {
  for (int degrees = -45; degrees < 135; degrees += 5) {
    const plain::Line line = {37.3, degrees + 0.4, -30.0, 45.0};
    const std::vector<rvdnav_peak> peaks = peaks_of_lines({line}, 3000, 30);
    REQUIRE(!peaks.empty());
    CHECK(plain::distance_at_ends(line, plain::rho_of(peaks[0]), plain::theta_of(peaks[0])) < 1.2);
    CHECK(peaks[0].votes > 40);
    CHECK(peaks[0].votes <= 110);
  }
}

TEST_CASE("parallel lines 5 pixels apart stay two, whatever their polarity") {
  for (int degrees = -45; degrees < 135; degrees += 9) {
    for (bool flipped : {false, true}) {
      const plain::Line a = {-60.0, degrees + 0.3, 10.0, 60.0}, b = {-55.0, degrees + 0.3, 5.0, 65.0, flipped};
      const std::vector<rvdnav_peak> peaks = peaks_of_lines({a, b}, 0, 20);
      CHECK(nearest(peaks, a) < 1.2);
      CHECK(nearest(peaks, b) < 1.2);
    }
  }
}

TEST_CASE("a line at the wrap is one peak with theta in range") {
  for (double degrees : {-45.0, -44.8, 134.6, 134.9}) {
    const plain::Line line = {80.0, degrees, -40.0, 40.0};
    const std::vector<rvdnav_peak> peaks = peaks_of_lines({line}, 0, 50);
    REQUIRE(peaks.size() == 1);
    CHECK(plain::distance_at_ends(line, plain::rho_of(peaks[0]), plain::theta_of(peaks[0])) < 1.0);
    CHECK(peaks[0].theta_q8 >= -45 * 256);
    CHECK(peaks[0].theta_q8 < 135 * 256);
  }
}

TEST_CASE("the best peaks are kept and sorted") {
  plain::Random random(12);
  std::vector<uint16_t> acc(static_cast<size_t>(kThetaBins * kRhoBins));
  for (int i = 0; i < 3000; ++i)
    acc[static_cast<size_t>(random.between(0, kThetaBins * kRhoBins - 1))] =
        static_cast<uint16_t>(random.between(5, 40));
  uint32_t total = 0, total_few = 0;
  const std::vector<rvdnav_peak> all = peaks_of(acc, kRhoBins, 5, 4096, &total);
  const std::vector<rvdnav_peak> few = peaks_of(acc, kRhoBins, 5, 37, &total_few);
  CHECK(total == all.size());
  CHECK(total_few == total);
  REQUIRE(total > 500);
  CHECK(std::is_sorted(all.begin(), all.end(), ranks_before));
  REQUIRE(few.size() == 37);
  for (size_t i = 0; i < few.size(); ++i) {
    CHECK(few[i].rho_q8 == all[i].rho_q8);
    CHECK(few[i].theta_q8 == all[i].theta_q8);
    CHECK(few[i].votes == all[i].votes);
  }
  CHECK(peaks_of(acc, kRhoBins, 5, 0, &total).empty());
  CHECK(total == all.size());
}

TEST_CASE("the list of peaks sorts like std::sort") {
  plain::Random random(13);
  for (int i = 0; i < 200; ++i) {
    const size_t count = static_cast<size_t>(random.between(0, 60)),
                 capacity = static_cast<size_t>(random.between(0, 40));
    std::vector<rvdnav_peak> given, kept(capacity);
    PeakList list(kept.data(), static_cast<uint32_t>(capacity));
    for (size_t k = 0; k < count; ++k) {
      given.push_back({random.between(-9, 9), random.between(-3, 3), static_cast<uint32_t>(random.between(0, 5))});
      list.add(given.back());
    }
    kept.resize(list.sort());
    std::sort(given.begin(), given.end(), ranks_before);
    given.resize(std::min(count, capacity));
    REQUIRE(kept.size() == given.size());
    for (size_t k = 0; k < kept.size(); ++k)
      REQUIRE((!ranks_before(kept[k], given[k]) && !ranks_before(given[k], kept[k])));
  }
}

TEST_CASE("the parabola finds the top of a parabola") {
  for (int top = -128; top <= 128; top += 16) {
    const auto f = [&](double x) {
      return static_cast<int32_t>(std::lround(1e6 - 1e4 * std::pow(x - top / 256.0, 2)));
    };
    CHECK(std::abs(parabola_q8(f(-1), f(0), f(1)) - top) <= 1);
  }
  CHECK(parabola_q8(5, 5, 5) == 0);
  CHECK(parabola_q8(0, 5, 40) == 0);
  CHECK(parabola_q8(1, 5, 8) == 128);
}
