#include <doctest/doctest.h>

#include <cstdint>
#include <cstring>
#include <limits>
#include <random>

#include "math/soft_double.hpp"

namespace soft = rvdnav::soft;

namespace {

uint64_t bits_of(double value) {
  uint64_t bits;
  std::memcpy(&bits, &value, sizeof bits);
  return bits;
}

double number_of(uint64_t bits) {
  double value;
  std::memcpy(&value, &bits, sizeof value);
  return value;
}

// Equal to the last bit; of NaN that it is one, since processors differ in which.
bool same(uint64_t ours, double processors) {
  return processors != processors ? soft::is_nan(ours) : ours == bits_of(processors);
}

// Sums of all pairs, which this machine's processor says.
void check_sums(uint64_t a, uint64_t b) {
  const double sum = number_of(a) + number_of(b);
  if (same(soft::add(a, b), sum)) return;
  CAPTURE(number_of(a));
  CAPTURE(number_of(b));
  CHECK(soft::add(a, b) == bits_of(sum));
}

}  // namespace

TEST_CASE("sums of doubles are the processor's") {
  std::mt19937_64 random(11);
  for (int i = 0; i < 500000; ++i) {
    const uint64_t a = random(), b = random();
    check_sums(a, b);
    // Exponents near each other, where bits are lost by ones.
    const uint64_t exponent = (a >> 52 & 0x7ff) + static_cast<uint64_t>(i % 129) - 64;
    check_sums(a, (b & (soft::kSign | soft::kFraction)) | (exponent & 0x7ff) << 52);
    // Few bits, for ties.
    check_sums(a & (soft::kSign | soft::kInfinity | 3), (b & (soft::kSign | 3)) | (exponent & 0x7ff) << 52);
  }
}

TEST_CASE("one less a number whose exponent is 33 lower is rounded to the nearest") {
  std::mt19937_64 random(12);
  for (int i = 0; i < 100000; ++i) {
    check_sums(bits_of(1.0), bits_of(-0x1p-33) | (random() & soft::kFraction));
  }
}

TEST_CASE("sums of zeros, subnormal numbers, the largest, infinities and NaN") {
  using limits = std::numeric_limits<double>;
  const double values[] = {0.0,
                           5e-324,
                           1e-310,
                           limits::min(),
                           1.0,
                           limits::max(),
                           limits::epsilon(),
                           limits::infinity(),
                           limits::quiet_NaN(),
                           0x1.fffffffffffffp-1022};
  for (const double a : values) {
    for (const double b : values) {
      for (const uint64_t signs : {0U, 1U, 2U, 3U}) {
        check_sums(bits_of(a) ^ (signs & 1) << 63, bits_of(b) ^ (signs >> 1) << 63);
      }
    }
  }
}

TEST_CASE("whole numbers and floats become the processor's doubles") {
  std::mt19937_64 random(13);
  bool equal = true;
  for (int i = 0; i < 300000; ++i) {
    const uint64_t value = random() >> (i % 64);
    const uint32_t word = static_cast<uint32_t>(random()) & (i % 8 == 0 ? 0x807fffffU : ~0U);
    float single;
    std::memcpy(&single, &word, sizeof single);
    equal = equal && same(soft::from_magnitude(0, value), static_cast<double>(value)) &&
            same(soft::from_signed(static_cast<int64_t>(value)), static_cast<double>(static_cast<int64_t>(value))) &&
            same(soft::from_signed(static_cast<int32_t>(value)), static_cast<double>(static_cast<int32_t>(value))) &&
            same(soft::from_float(word), static_cast<double>(single));
  }
  CHECK(equal);
  CHECK(soft::from_signed(0) == 0);
  CHECK(same(soft::from_signed(std::numeric_limits<int64_t>::min()), -0x1p63));
  for (const uint32_t word : {0U, 0x80000000U, 1U, 0x007fffffU, 0x00800000U, 0x7f800000U, 0xff800000U, 0x7fc00000U}) {
    float single;
    std::memcpy(&single, &word, sizeof single);
    CHECK(same(soft::from_float(word), static_cast<double>(single)));
  }
}
