// The row kernels for AVX2; the build gives this file alone the flag that allows it.
#include "kernels/kernel_sets.hpp"

#if RVDNAV_BUILD_X86
#ifndef __AVX2__
#error "compile this file for AVX2"
#endif

#include <immintrin.h>

#include "angle.hpp"
#include "hough.hpp"
#include "hough_trig.hpp"
#include "integers.hpp"
#include "tangent.hpp"

namespace rvdnav {
namespace avx2 {
namespace plain {
#include "kernels/edgel_kernels.inl"
#include "kernels/row_kernels.inl"
}  // namespace plain

using Bytes = uint8_t __attribute__((vector_size(32)));
using Shorts = int16_t __attribute__((vector_size(32)));
using UShorts = uint16_t __attribute__((vector_size(32)));
using Words = uint32_t __attribute__((vector_size(32)));
using Mask = uint32_t;

constexpr Words kLane = {0, 1, 2, 3, 4, 5, 6, 7};

// Unpacked and packed within each half of the vectors: bytes 0 to 7 and 16 to 23 in lo, the others in hi.
struct Pair {
  Shorts lo, hi;
};

template <typename Vector>
static inline __m256i raw(Vector v) {
  return reinterpret_cast<__m256i>(v);
}
static inline Shorts shorts(__m256i v) { return reinterpret_cast<Shorts>(v); }

static inline Pair widen(Bytes a) {
  const __m256i zero = _mm256_setzero_si256();
  return {shorts(_mm256_unpacklo_epi8(raw(a), zero)), shorts(_mm256_unpackhi_epi8(raw(a), zero))};
}

// a * (low byte of factors) + b * (high byte), both signed
static inline Pair multiply_add(Bytes a, Bytes b, int16_t factors) {
  const __m256i both = _mm256_set1_epi16(factors);
  return {shorts(_mm256_maddubs_epi16(_mm256_unpacklo_epi8(raw(a), raw(b)), both)),
          shorts(_mm256_maddubs_epi16(_mm256_unpackhi_epi8(raw(a), raw(b)), both))};
}
static inline Pair difference(Bytes a, Bytes b) { return multiply_add(a, b, -0x00ff); }
static inline Pair total(Bytes a, Bytes b) { return multiply_add(a, b, 0x0101); }

static inline Bytes narrow(Pair v) { return reinterpret_cast<Bytes>(_mm256_packus_epi16(raw(v.lo), raw(v.hi))); }

static inline void store_pair(int16_t* p, Pair v) {
  auto* const out = reinterpret_cast<__m256i*>(p);
  _mm256_storeu_si256(out, _mm256_permute2x128_si256(raw(v.lo), raw(v.hi), 0x20));
  _mm256_storeu_si256(out + 1, _mm256_permute2x128_si256(raw(v.lo), raw(v.hi), 0x31));
}

static inline Shorts widen_at(const uint8_t* p) {
  return shorts(_mm256_cvtepu8_epi16(_mm_loadu_si128(reinterpret_cast<const __m128i*>(p))));
}

static inline Shorts high_product(UShorts a, uint16_t b) {
  return shorts(_mm256_mulhi_epu16(raw(a), _mm256_set1_epi16(static_cast<int16_t>(b))));
}

static inline UShorts capped_sum(UShorts a, UShorts b) {
  return reinterpret_cast<UShorts>(_mm256_adds_epu16(raw(a), raw(b)));
}

using Sums = __m256i;
static inline Sums add_up(Sums sums, Bytes v) {
  return _mm256_add_epi64(sums, _mm256_sad_epu8(raw(v), _mm256_setzero_si256()));
}
static inline uint64_t total_of(Sums sums) {
  uint64_t part[4];
  __builtin_memcpy(part, &sums, sizeof part);
  return part[0] + part[1] + part[2] + part[3];
}

// Every word moved to the next or to the previous lane; a 0 comes in.
static inline Words one_lane_on(Words v) {
  return reinterpret_cast<Words>(_mm256_alignr_epi8(raw(v), _mm256_permute2x128_si256(raw(v), raw(v), 0x08), 12));
}
static inline Words one_lane_back(Words v) {
  return reinterpret_cast<Words>(_mm256_alignr_epi8(_mm256_permute2x128_si256(raw(v), raw(v), 0x81), raw(v), 4));
}

template <typename Vector>
static inline bool any(Vector v) {
  return _mm256_testz_si256(raw(v), raw(v)) == 0;
}

static inline Mask mask_bits(Shorts lo, Shorts hi) {
  const __m256i crossed = _mm256_packs_epi16(raw(lo), raw(hi));
  return static_cast<Mask>(_mm256_movemask_epi8(_mm256_permute4x64_epi64(crossed, 0xd8)));
}

#include "kernels/edgel_lanes.inl"
#include "kernels/lane_kernels.inl"
}  // namespace avx2

const Kernels kAvx2Kernels = {RVDNAV_ISA_AVX2,       avx2::plain::smooth_row, avx2::gradient_row, avx2::ridge_row,
                              avx2::deletable_row,   avx2::touching_row,      avx2::light_row,    avx2::high_cells,
                              avx2::gradient_levels, avx2::rectify_pixels,    avx2::vote};

}  // namespace rvdnav
#endif
