// Sums and conversions of doubles in integer arithmetic, rounded to nearest, ties to even, as IEEE 754 has them: for
// processors without a floating-point unit, where the compiler's library rounds some differences wrongly.
#pragma once

#include <cstdint>

namespace rvdnav {
namespace soft {

constexpr int32_t kFractionBits = 52;
constexpr int32_t kBias = 1023;
constexpr int32_t kSpecialExponent = 0x7ff;  // of infinities and NaN
constexpr uint64_t kSign = 1ULL << 63;
constexpr uint64_t kHidden = 1ULL << kFractionBits;
constexpr uint64_t kFraction = kHidden - 1;
constexpr uint64_t kInfinity = static_cast<uint64_t>(kSpecialExponent) << kFractionBits;
constexpr uint64_t kQuiet = kHidden >> 1;

// Below a significand while it is worked on: two bits for rounding, and one that says whether anything else was lost.
constexpr int32_t kGuardBits = 3;
constexpr int32_t kTopBit = kFractionBits + kGuardBits;

constexpr int32_t exponent_of(uint64_t bits) { return static_cast<int32_t>(bits >> kFractionBits) & kSpecialExponent; }

// Of a finite number, with guard bits; subnormal numbers have the exponent 1, but no hidden bit.
constexpr uint64_t significand_of(uint64_t bits) {
  return ((bits & kFraction) | (exponent_of(bits) != 0 ? kHidden : 0)) << kGuardBits;
}

constexpr uint64_t shift_right_sticky(uint64_t value, int32_t by) {
  if (by > kTopBit) return value != 0 ? 1 : 0;
  const uint64_t lost = value & ((1ULL << by) - 1);
  return value >> by | (lost != 0 ? 1 : 0);
}

// significand: below 2^(kTopBit + 1); without its top bit only if the exponent is 1.  A carry goes into the exponent,
// and beyond the largest one is infinity.
constexpr uint64_t round_and_pack(uint64_t sign, int32_t exponent, uint64_t significand) {
  if (exponent >= kSpecialExponent) return sign | kInfinity;
  const uint64_t guard = significand & ((1U << kGuardBits) - 1);
  uint64_t kept = significand >> kGuardBits;
  constexpr uint64_t kHalf = 1U << (kGuardBits - 1);
  kept += guard > kHalf || (guard == kHalf && (kept & 1) != 0) ? 1 : 0;
  return sign | ((static_cast<uint64_t>(exponent - 1) << kFractionBits) + kept);
}

constexpr bool is_nan(uint64_t bits) { return (bits & ~kSign) > kInfinity; }

// One of the two is an infinity or NaN.
constexpr uint64_t add_special(uint64_t a, uint64_t b) {
  if (is_nan(a)) return a | kQuiet;
  if (is_nan(b)) return b | kQuiet;
  if (exponent_of(a) != kSpecialExponent) return b;
  const bool opposite = exponent_of(b) == kSpecialExponent && a != b;
  return opposite ? kInfinity | kQuiet : a;
}

constexpr uint64_t add(uint64_t a, uint64_t b) {
  const bool b_larger = (b & ~kSign) > (a & ~kSign);
  const uint64_t large = b_larger ? b : a;
  const uint64_t small = b_larger ? a : b;
  int32_t exponent = exponent_of(large);
  if (exponent == kSpecialExponent) return add_special(a, b);
  exponent += exponent == 0 ? 1 : 0;
  const int32_t small_exponent = exponent_of(small);
  const int32_t distance = exponent - small_exponent - (small_exponent == 0 ? 1 : 0);
  const uint64_t moved = shift_right_sticky(significand_of(small), distance);
  const uint64_t sign = large & kSign;
  if (((a ^ b) & kSign) == 0) {
    const uint64_t sum = significand_of(large) + moved;
    const bool carry = sum >> (kTopBit + 1) != 0;
    return carry ? round_and_pack(sign, exponent + 1, shift_right_sticky(sum, 1)) : round_and_pack(sign, exponent, sum);
  }
  const uint64_t difference = significand_of(large) - moved;
  if (difference == 0) return 0;
  const int32_t wanted = __builtin_clzll(difference) - (63 - kTopBit);
  const int32_t possible = wanted < exponent ? wanted : exponent - 1;
  return round_and_pack(sign, exponent - possible, difference << possible);
}

constexpr uint64_t from_magnitude(uint64_t sign, uint64_t magnitude) {
  if (magnitude == 0) return 0;
  const int32_t zeros = __builtin_clzll(magnitude);
  return round_and_pack(sign, kBias + 63 - zeros, shift_right_sticky(magnitude << zeros, 63 - kTopBit));
}

constexpr uint64_t from_signed(int64_t value) {
  const uint64_t magnitude = static_cast<uint64_t>(value);
  return value < 0 ? from_magnitude(kSign, 0 - magnitude) : from_magnitude(0, magnitude);
}

// A float's bits.
constexpr uint64_t from_float(uint32_t bits) {
  const uint64_t sign = static_cast<uint64_t>(bits >> 31) << 63;
  const int32_t exponent = static_cast<int32_t>(bits >> 23) & 0xff;
  const uint64_t fraction = bits & 0x7fffffU;
  constexpr int32_t kMore = kFractionBits - 23;
  if (exponent == 0xff) return sign | kInfinity | (fraction != 0 ? kQuiet | fraction << kMore : 0);
  if (exponent != 0) return sign | (static_cast<uint64_t>(exponent + kBias - 127) << kFractionBits) | fraction << kMore;
  if (fraction == 0) return sign;
  const int32_t zeros = __builtin_clzll(fraction) - (63 - 23);  // above where the hidden bit comes to stand
  const uint64_t shifted = fraction << zeros << kMore;
  return sign | (static_cast<uint64_t>(kBias - 126 - zeros) << kFractionBits) | (shifted & kFraction);
}

}  // namespace soft
}  // namespace rvdnav
