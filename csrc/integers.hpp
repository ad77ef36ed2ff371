// What the integer stages share of arithmetic.
#pragma once

#include <stdint.h>

namespace rvdnav {

constexpr int32_t round_half_away(double value) { return static_cast<int32_t>(value < 0 ? value - 0.5 : value + 0.5); }

// v / 2^n rounded down, for negative v too.
constexpr int32_t floor_shift(int32_t v, int32_t n) { return v >= 0 ? v >> n : ~(~v >> n); }
constexpr int64_t floor_shift(int64_t v, int32_t n) { return v >= 0 ? v >> n : ~(~v >> n); }

// v / d rounded to the nearest, d positive.
constexpr int32_t round_divide(int32_t v, int32_t d) { return (v >= 0 ? v + d / 2 : v - d / 2) / d; }

constexpr int32_t magnitude(int32_t v) { return v < 0 ? -v : v; }
constexpr int32_t smaller(int32_t a, int32_t b) { return a < b ? a : b; }
constexpr int32_t larger(int32_t a, int32_t b) { return a > b ? a : b; }
constexpr int32_t clamp(int32_t v, int32_t low, int32_t high) { return smaller(larger(v, low), high); }

}  // namespace rvdnav
