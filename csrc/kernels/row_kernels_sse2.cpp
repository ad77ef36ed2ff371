// The row kernels for SSE2, which every 64-bit x86 processor has.
#include "kernels/kernel_sets.hpp"

#if RVDNAV_BUILD_X86

#include <emmintrin.h>

#include "angle.hpp"
#include "hough.hpp"
#include "hough_trig.hpp"
#include "integers.hpp"
#include "tangent.hpp"

namespace rvdnav {
namespace sse2 {
namespace plain {
#include "kernels/edgel_kernels.inl"
#include "kernels/row_kernels.inl"
}  // namespace plain

using Bytes = uint8_t __attribute__((vector_size(16)));
using Shorts = int16_t __attribute__((vector_size(16)));
using UShorts = uint16_t __attribute__((vector_size(16)));
using Words = uint32_t __attribute__((vector_size(16)));
using Mask = uint16_t;

// The first and the last eight.
struct Pair {
  Shorts lo, hi;
};

template <typename Vector>
static inline __m128i raw(Vector v) {
  return reinterpret_cast<__m128i>(v);
}
static inline Shorts shorts(__m128i v) { return reinterpret_cast<Shorts>(v); }

static inline Pair widen(Bytes a) {
  const __m128i zero = _mm_setzero_si128();
  return {shorts(_mm_unpacklo_epi8(raw(a), zero)), shorts(_mm_unpackhi_epi8(raw(a), zero))};
}
static inline Pair difference(Bytes a, Bytes b) {
  const Pair x = widen(a), y = widen(b);
  return {x.lo - y.lo, x.hi - y.hi};
}
static inline Pair total(Bytes a, Bytes b) {
  const Pair x = widen(a), y = widen(b);
  return {x.lo + y.lo, x.hi + y.hi};
}

static inline Bytes narrow(Pair v) { return reinterpret_cast<Bytes>(_mm_packus_epi16(raw(v.lo), raw(v.hi))); }

static inline void store_pair(int16_t* p, Pair v) {
  auto* const out = reinterpret_cast<__m128i*>(p);
  _mm_storeu_si128(out, raw(v.lo));
  _mm_storeu_si128(out + 1, raw(v.hi));
}

static inline Shorts widen_at(const uint8_t* p) {
  return shorts(_mm_unpacklo_epi8(_mm_loadl_epi64(reinterpret_cast<const __m128i*>(p)), _mm_setzero_si128()));
}

static inline Shorts high_product(UShorts a, uint16_t b) {
  return shorts(_mm_mulhi_epu16(raw(a), _mm_set1_epi16(static_cast<int16_t>(b))));
}

static inline UShorts capped_sum(UShorts a, UShorts b) {
  return reinterpret_cast<UShorts>(_mm_adds_epu16(raw(a), raw(b)));
}

using Sums = __m128i;
static inline Sums add_up(Sums sums, Bytes v) { return _mm_add_epi64(sums, _mm_sad_epu8(raw(v), _mm_setzero_si128())); }
static inline uint64_t total_of(Sums sums) {
  uint64_t part[2];
  __builtin_memcpy(part, &sums, sizeof part);
  return part[0] + part[1];
}

// Every word moved to the next or to the previous lane; a 0 comes in.
static inline Words one_lane_on(Words v) { return reinterpret_cast<Words>(_mm_slli_si128(raw(v), 4)); }
static inline Words one_lane_back(Words v) { return reinterpret_cast<Words>(_mm_srli_si128(raw(v), 4)); }

template <typename Vector>
static inline bool any(Vector v) {
  return _mm_movemask_epi8(_mm_cmpeq_epi8(raw(v), _mm_setzero_si128())) != 0xffff;
}

static inline Mask mask_bits(Shorts lo, Shorts hi) {
  return static_cast<Mask>(_mm_movemask_epi8(_mm_packs_epi16(raw(lo), raw(hi))));
}

#include "kernels/lane_kernels.inl"
}  // namespace sse2

const Kernels kSse2Kernels = {RVDNAV_ISA_SSE2,
                              sse2::plain::smooth_row,
                              sse2::gradient_row,
                              sse2::ridge_row,
                              sse2::deletable_row,
                              sse2::touching_row,
                              sse2::light_row,
                              sse2::high_cells,
                              sse2::plain::gradient_levels,
                              sse2::plain::rectify_pixels,
                              sse2::plain::vote};

}  // namespace rvdnav
#endif
